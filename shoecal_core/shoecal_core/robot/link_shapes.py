"""Shapes of a URDF's links, as corners."""

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

from shoecal_core.arrays import FloatArray
from shoecal_core.files import read_bytes
from shoecal_core.robot.mesh_files import LFS_POINTER, find_mesh
from shoecal_core.robot.native_output import caught_stderr
from shoecal_core.robot.urdf import UrdfError

CIRCLE = 32
"""Points for a circle; the first lies on an axis of its shape."""

Y_UP = b"<up_axis>Y_UP</up_axis>"
Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Description:
    """A URDF as its shapes are read.

    Attributes:
        urdf: the file.
        root: its elements.
        model: on a free-flying base.
        meshes: folder in which its meshes are, where they are not where the file says.
    """

    urdf: Path
    root: ElementTree.Element
    model: pin.Model
    meshes: Path | None


@dataclass(frozen=True)
class Shapes:
    """Shapes of some joints' links.

    Attributes:
        points: (k, 3) corners by joint, each in its joint's frame [m].
        missing: by joint, mesh files of links of which no shape is there, each with what is the
            matter with it.
    """

    points: Mapping[int, FloatArray]
    missing: Mapping[int, tuple[str, ...]]


def find_shapes(of: Description, joints: set[int]) -> Shapes:
    """Corners of the shapes of these joints' links.

    A link's collision shapes, or its visual ones where it has no other. Curved shapes are drawn
    with corners; those on a shape's own axes lie on its surface exactly.

    Raises:
        FileError: for shapes that are not understood.
    """
    links = {
        str(frame.name): int(frame.parentJoint)
        for frame in of.model.frames
        if frame.type == pin.FrameType.BODY and frame.parentJoint in joints
    }
    root, lost = _without_lost_meshes(of, set(links))
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
        for item in _geometry(of, root, kind, tag, wanted):
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


def _without_lost_meshes(
    of: Description, links: set[str]
) -> tuple[ElementTree.Element, dict[str, tuple[str, ...]]]:
    """The URDF without shapes whose meshes cannot be had, and these by link.

    Descriptions are often installed without their meshes, which are another package.
    """
    root = copy.deepcopy(of.root)
    missing: dict[str, tuple[str, ...]] = {}
    for link in root.iter("link"):
        name = link.get("name", "")
        for tag in ("collision", "visual"):
            for shape in link.findall(tag) if name in links else ():
                mesh = shape.find("geometry/mesh")
                file = "" if mesh is None else mesh.get("filename", "")
                if file and (why := _trouble(of, file)):
                    link.remove(shape)
                    missing[name] = (*missing.get(name, ()), f"{file} {why}")
        if link.find("collision/geometry") is not None or link.find("visual/geometry") is not None:
            missing.pop(name, None)
    return root, missing


def _trouble(of: Description, file: str) -> str:
    """What is the matter with a mesh file; empty where it can be used."""
    there = find_mesh(of.urdf, file, of.meshes)
    if there is None:
        return "is not there"
    content = read_bytes(there)
    if not content:
        return "is empty"
    if content.startswith(LFS_POINTER):
        return "is a Git LFS pointer (run git lfs pull)"
    try:
        with caught_stderr():
            coal.MeshLoader().load(str(there), np.ones(3))
    except (ValueError, RuntimeError):
        return "is no mesh that can be read"
    return ""


def _geometry(
    of: Description, root: ElementTree.Element, kind: pin.GeometryType, tag: str, wanted: set[str]
) -> list[Any]:
    """Shapes of these links alone: what is wrong with the others does not matter."""
    robot = ElementTree.Element("robot", {"name": "part"})
    for element in root:
        part = ElementTree.Element(element.tag, element.attrib)
        part.extend(
            copy.deepcopy(child)
            for child in element
            if child.tag not in ("collision", "visual")
            or (child.tag == tag and element.get("name") in wanted)
        )
        for mesh in part.iter("mesh"):
            there = find_mesh(of.urdf, mesh.get("filename", ""), of.meshes)
            mesh.set("filename", "" if there is None else str(there))
        if element.tag in ("link", "joint", "material"):
            robot.append(part)
    try:
        with caught_stderr():
            geometry = pin.buildGeomFromUrdfString(
                of.model,
                ElementTree.tostring(robot, encoding="unicode"),
                kind,
            )
    except (ValueError, RuntimeError) as error:
        reason = str(error).splitlines()[0] if str(error) else "rejected by the parser"
        raise UrdfError(
            of.urdf,
            f"a shape of its legs cannot be read: {reason}; repair that shape or take it out",
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
