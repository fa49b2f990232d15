"""A URDF as a draft looks at it: its model in the zero pose and the shapes of its links."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from shoecal_core.files import read_bytes
from shoecal_core.model.native_output import caught_stderr
from shoecal_core.model.symbolic import joint_axis
from shoecal_core.model.urdf import ROOT_JOINTS, Mimic, UrdfError, read_urdf

FloatArray = NDArray[np.float64]

CIRCLE = 32
"""Points for a circle; the first lies on an axis of its shape."""

Y_UP = b"<up_axis>Y_UP</up_axis>"
Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Body:
    """A robot in its zero pose, base at the origin.

    Attributes:
        urdf: the file.
        root: its elements.
        model: on a free-flying base.
        mimics: joints that another one's motor turns.
        placements: of every joint of the model, in the base.
    """

    urdf: Path
    root: ElementTree.Element
    model: pin.Model
    mimics: Mapping[str, Mimic]
    placements: tuple[pin.SE3, ...]

    def origin(self, joint: int) -> FloatArray:
        """(3,) of a joint of the model, in the base [m]."""
        return np.asarray(self.placements[joint].translation)

    def axis(self, joint: int) -> FloatArray:
        """(3,) unit axis about which it turns, in the base."""
        linear, angular = joint_axis(self.model, joint)
        axis = self.placements[joint].rotation @ (linear + angular)
        return np.asarray(axis / np.linalg.norm(axis))

    def link(self, joint: int) -> tuple[str, pin.SE3]:
        """The link that a joint turns, and its frame in the joint's frame.

        Raises:
            UrdfError: for a joint without a link.
        """
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY and frame.parentJoint == joint:
                return str(frame.name), pin.SE3(frame.placement)
        raise UrdfError(self.urdf, "carries no link", field=f"joint {self.model.names[joint]}")

    def range(self, joint: int) -> tuple[float, float]:
        """Lower and upper limit of a joint [rad]."""
        place = self.model.joints[joint].idx_q
        return float(self.model.lowerPositionLimit[place]), float(
            self.model.upperPositionLimit[place]
        )


def read_body(urdf: Path) -> Body:
    """Read a URDF.

    Raises:
        FileError: for one that is not understood whole: no masses, no limits, broken joints.
    """
    description = read_urdf(urdf)
    data = description.model.createData()
    zero = np.zeros(description.model.nq)
    zero[6] = 1.0
    pin.forwardKinematics(description.model, data, zero)
    # read_urdf has refused document types, so no entity can unfold here.
    root = ElementTree.parse(urdf).getroot()  # noqa: S314
    return Body(
        urdf,
        root,
        description.model,
        description.mimics,
        tuple(pin.SE3(placement) for placement in data.oMi),
    )


@dataclass(frozen=True)
class Shapes:
    """Shapes of some joints' links.

    Attributes:
        points: (k, 3) corners by joint, each in its joint's frame [m].
        missing: by joint, mesh files of links of which no shape is there.
    """

    points: Mapping[int, FloatArray]
    missing: Mapping[int, tuple[str, ...]]


def find_shapes(body: Body, joints: set[int]) -> Shapes:
    """Corners of the shapes of these joints' links.

    A link's collision shapes, or its visual ones where it has no other. Curved shapes are drawn
    with corners; those on a shape's own axes lie on its surface exactly.

    Raises:
        FileError: for a mesh that is there and cannot be read.
    """
    links = {
        str(frame.name): int(frame.parentJoint)
        for frame in body.model.frames
        if frame.type == pin.FrameType.BODY and frame.parentJoint in joints
    }
    root, lost = _without_missing_meshes(body, set(links))
    collision = {
        link.get("name")
        for link in root.iter("link")
        if link.get("name") in links and link.find("collision/geometry") is not None
    }
    points: dict[int, list[FloatArray]] = {joint: [] for joint in joints}
    for kind, tag in (
        (pin.GeometryType.COLLISION, "collision"),
        (pin.GeometryType.VISUAL, "visual"),
    ):
        wanted = {name for name in links if (name in collision) == (tag == "collision")}
        for item in _geometry(body, root, kind, tag, wanted):
            corners = _upright(item, _corners(item.geometry))
            points[int(item.parentJoint)].append(
                np.array([item.placement.act(point) for point in corners]).reshape(-1, 3)
            )
    missing: dict[int, tuple[str, ...]] = dict.fromkeys(joints, ())
    for link, files in lost.items():
        missing[links[link]] += files
    corners_of = {
        joint: np.concatenate(found) if found else np.zeros((0, 3))
        for joint, found in points.items()
    }
    return Shapes(corners_of, missing)


def _without_missing_meshes(
    body: Body, links: set[str]
) -> tuple[ElementTree.Element, dict[str, tuple[str, ...]]]:
    """The URDF without shapes whose meshes are not there, and their files by link.

    Descriptions are often installed without their meshes, which are another package.
    """
    root = copy.deepcopy(body.root)
    missing: dict[str, tuple[str, ...]] = {}
    for link in root.iter("link"):
        name = link.get("name", "")
        for tag in ("collision", "visual"):
            for shape in link.findall(tag) if name in links else ():
                mesh = shape.find("geometry/mesh")
                file = "" if mesh is None else mesh.get("filename", "")
                if file and not _exists(body, file):
                    link.remove(shape)
                    missing[name] = (*missing.get(name, ()), file)
        if link.find("collision/geometry") is not None or link.find("visual/geometry") is not None:
            missing.pop(name, None)
    return root, missing


def _folders(body: Body) -> list[Path]:
    """Where packages are looked for: the folders above the URDF."""
    return list(body.urdf.resolve().parents)[:-1]


def _exists(body: Body, file: str) -> bool:
    scheme, _, rest = file.rpartition("://")
    if scheme == "file":
        return Path(rest).is_file()
    return any((folder / rest).is_file() for folder in _folders(body))


def _geometry(
    body: Body, root: ElementTree.Element, kind: pin.GeometryType, tag: str, wanted: set[str]
) -> list[Any]:
    """Shapes of these links alone: what is wrong with the others does not matter."""
    robot = ElementTree.Element("robot", {"name": "part"})
    for element in root:
        part = ElementTree.Element(element.tag, element.attrib)
        part.extend(
            child
            for child in element
            if child.tag not in ("collision", "visual")
            or (child.tag == tag and element.get("name") in wanted)
        )
        if element.tag in ("link", "joint", "material"):
            robot.append(part)
    try:
        with caught_stderr():
            geometry = pin.buildGeomFromUrdfString(
                body.model,
                ElementTree.tostring(robot, encoding="unicode"),
                kind,
                package_dirs=[str(folder) for folder in _folders(body)],
            )
    except (ValueError, RuntimeError) as error:
        reason = str(error).splitlines()[0] if str(error) else "rejected by the parser"
        raise UrdfError(
            body.urdf,
            f"a shape of its legs cannot be read: {reason}; repair that mesh or take it out",
            field=tag,
        ) from error
    return list(geometry.geometryObjects)


def _corners(shape: object) -> FloatArray:
    """(k, 3) corners of one shape in its own frame [m]."""
    if isinstance(shape, coal.BVHModelBase):
        return np.asarray(shape.vertices())
    if isinstance(shape, coal.ConvexBase):
        return np.asarray(shape.points())
    if isinstance(shape, coal.Box):
        signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
        return signs * np.asarray(shape.halfSide, dtype=np.float64)
    if isinstance(shape, coal.Sphere):
        return _ball() * float(shape.radius)
    if isinstance(shape, coal.Capsule | coal.Cylinder):
        ring = _ball() if isinstance(shape, coal.Capsule) else _circle()
        end = np.array([0.0, 0.0, shape.halfLength])
        rim = ring * float(shape.radius)
        return np.concatenate([rim + end, rim - end])
    return np.zeros((0, 3))


def _upright(item: Any, corners: FloatArray) -> FloatArray:
    """Corners of a mesh with z upward: a Collada file may say that its y axis is up."""
    file = Path(item.meshPath) if item.meshPath else None
    if file is None or file.suffix.lower() != ".dae" or Y_UP not in read_bytes(file):
        return corners
    scale = np.asarray(item.meshScale)
    return np.asarray((corners / scale) @ Y_TO_Z.T * scale)


def _circle() -> FloatArray:
    angles = np.arange(CIRCLE) * 2.0 * np.pi / CIRCLE
    return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(CIRCLE)])


def _ball() -> FloatArray:
    """Unit vectors on three great circles, the axes among them."""
    circle = _circle()
    return np.concatenate([circle, circle[:, [0, 2, 1]], circle[:, [2, 0, 1]]])


def own_joints(model: pin.Model) -> range:
    """The robot's joints, without those of the base."""
    return range(ROOT_JOINTS, model.njoints)
