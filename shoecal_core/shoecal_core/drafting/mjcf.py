"""A robot in MJCF as a URDF: MuJoCo reads it, and what it compiled is written down.

So nothing that follows knows of MJCF: defaults, includes, units of angles and compiler settings are
MuJoCo's own. A body with several joints becomes as many links; a joint's frame is at its anchor.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
from mujoco import mjtEq, mjtGeom, mjtJoint, mjtObj, mjtSensor, mjtTrn
from scipy.spatial import ConvexHull, QhullError

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.closed_chains import LOOP
from shoecal_core.drafting.notes import Note
from shoecal_core.files import atomic_write, make_folder
from shoecal_core.robot.mjcf import MOVING, MjcfError, read_mjcf
from shoecal_core.robot.urdf import written

SPEED = 3.0
"""rad/s; MJCF has no speeds of motors. Slower than the knee of any humanoid, and ten times faster
than what is planned."""
EFFORT_M = 0.2
"""Of motors without a limit of their torque, by the robot's weight: what a knee of a robot that
bends it holds."""
MOST_EFFORT_M = 2.0
"""A limit that holds the robot's weight on a longer arm is a number to be out of the way, no
motor's: the strongest humanoids' hold it at 0.6 m."""
PLAY_RAD = 0.1
"""A joint without a motor that turns by less is play of gears, not a joint."""


@dataclass(frozen=True)
class Converted:
    """A robot as a URDF.

    Attributes:
        urdf: its text.
        meshes: STL files by the paths that the URDF names them by.
        assumed: what the MJCF does not say and was put in, with what to check.
        keyframes: postures by name, each with its angles by joint [rad or m].
    """

    urdf: str
    meshes: Mapping[str, bytes]
    assumed: tuple[Note, ...]
    keyframes: Mapping[str, Mapping[str, float]]

    def write(self, urdf: Path) -> Path:
        """Write the URDF, and the meshes next to it; the URDF's path."""
        for name, content in self.meshes.items():
            file = urdf.parent / name
            make_folder(file.parent)
            atomic_write(file, content)
        make_folder(urdf.parent)
        atomic_write(urdf, self.urdf)
        return urdf


def as_urdf(path: Path, meshes: str) -> Converted:
    """Read a robot's MJCF.

    Args:
        path: of the MJCF; what it includes is looked for where MuJoCo does.
        meshes: folder of the meshes, next to the URDF.

    Raises:
        MjcfError: for a model that MuJoCo does not compile, or that has other joints than
            hinges and slides.
    """
    lost: list[str] = []
    return _Writer(path, read_mjcf(path, lost)[1], meshes, lost).written()


class _Writer:
    """Writes one compiled model."""

    def __init__(self, path: Path, model: mujoco.MjModel, folder: str, lost: Sequence[str]) -> None:
        self._path, self._model, self._folder, self._lost = path, model, folder, lost
        self._base = self._find_base()
        self._bodies = set(self._below(self._base))
        self._weight = float(model.body_subtreemass[self._base]) * float(
            np.linalg.norm(model.opt.gravity) or 9.81
        )
        self._robot = ElementTree.Element("robot", {"name": path.stem})
        self._meshes: dict[str, bytes] = {}
        self._weak: list[str] = []
        self._endless: list[str] = []
        self._loose: list[str] = []
        self._check()

    def written(self) -> Converted:
        """The URDF and its meshes."""
        self._write_body(self._base, "")
        self._write_sensors()
        for name, *ends in self._closing():
            loop = ElementTree.SubElement(self._robot, LOOP, {"name": name})
            for tag, end in zip(("link1", "link2"), ends, strict=True):
                ElementTree.SubElement(loop, tag, {"link": self._link_name(end)})
        ElementTree.indent(self._robot)
        text = ElementTree.tostring(self._robot, encoding="unicode")
        own = "give the motors' own there."
        speeds = f"MJCF has no speeds of motors: {SPEED:g} rad/s is each one's limit."
        assumed = [Note("joint", speeds, own)]
        if self._base == 0:
            lost = "all hangs on the world, where the base's mass is lost."
            cure = "make the base a body with a free joint and its mass, and draft again."
            assumed.append(Note("link", lost, cure))
        if self._lost:
            more = len(self._lost) - 1
            without = f"mesh {self._lost[0]}{f', and {more} more' if more else ''}: left out."
            fetch = "soles and capsules are those of the other shapes; else fetch the meshes."
            assumed.append(Note("link", without, fetch))
        if self._loose:
            loose = f"{', '.join(self._loose)}: play of gears, not joints: fixed."
            look = "no motor turns them; the robot file's joint_deflection has their play."
            assumed.append(Note("joint", loose, look))
        effort = f"{EFFORT_M * self._weight:.3g} N m put in."
        if self._endless:
            beyond = f"{', '.join(self._endless)}: more than any motor of such a robot, {effort}"
            assumed.append(Note("joint", beyond, own))
        if self._weak:
            assumed.append(
                Note("joint", f"{', '.join(self._weak)}: no limit of torque, {effort}", own)
            )
        return Converted(f"{text}\n", self._meshes, tuple(assumed), self._keyframes())

    def _keyframes(self) -> dict[str, dict[str, float]]:
        model = self._model
        joints = {
            self._name(mjtObj.mjOBJ_JOINT, joint): int(model.jnt_qposadr[joint])
            for body in self._bodies
            for joint in self._moving(body)
        }
        return {
            self._name(mjtObj.mjOBJ_KEY, key): {
                name: float(model.key_qpos[key][place]) for name, place in joints.items()
            }
            for key in range(model.nkey)
        }

    def _find_base(self) -> int:
        """The body whose tree has most joints: the one with a free joint, or welded to the world.

        The world itself where all hangs on it: a URDF that MuJoCo reads loses its base there.
        """
        roots = [one for one in self._children(0) if self._joints_below(one)]
        if not roots:
            raise MjcfError(self._path, "has no joints; give the model of the robot")
        best = max(roots, key=lambda one: len(self._joints_below(one)))
        return best if self._floats(best) or not self._joints_of(best) else 0

    def _floats(self, body: int) -> bool:
        """By a free joint, or three slides and what turns them, none of which has a motor."""
        joints, model = self._joints_of(body), self._model
        kinds = [mjtJoint(int(model.jnt_type[joint])) for joint in joints]
        driven = any(self._motors(joint) for joint in joints)
        return mjtJoint.mjJNT_FREE in kinds or (
            model.body_parentid[body] == 0 and kinds.count(mjtJoint.mjJNT_SLIDE) == 3 and not driven
        )

    def _check(self) -> None:
        model, closed = self._model, set[int]()
        for _, one, other in self._closing():
            closed |= self._above(one) ^ self._above(other)
        for joint in range(model.njnt):
            body = int(model.jnt_bodyid[joint])
            # Balls of rods that close a chain stay as they are: the chain does.
            if body not in self._bodies or self._floats(body) or body in closed:
                continue
            if model.jnt_type[joint] == mjtJoint.mjJNT_BALL:
                raise MjcfError(
                    self._path,
                    "is a ball joint; give three hinges in its place",
                    field=f"joint {self._name(mjtObj.mjOBJ_JOINT, joint)}",
                )

    def _closing(self) -> list[tuple[str, int, int]]:
        """What closes chains of links: its name, and the two bodies that it holds together."""
        model, found = self._model, []
        for one in range(model.neq):
            kind = mjtEq(int(model.eq_type[one]))
            ends = (int(model.eq_obj1id[one]), int(model.eq_obj2id[one]))
            if kind not in (mjtEq.mjEQ_CONNECT, mjtEq.mjEQ_WELD) or not model.eq_active0[one]:
                continue
            if model.eq_objtype[one] == mjtObj.mjOBJ_SITE:
                ends = (int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]]))
            if set(ends) <= self._bodies:
                found.append((self._name(mjtObj.mjOBJ_EQUALITY, one), *ends))
        return found

    def _above(self, body: int) -> set[int]:
        """A body and those that it hangs on, the world left out."""
        found = set[int]()
        while body:
            found.add(body)
            body = int(self._model.body_parentid[body])
        return found

    # The tree

    def _children(self, body: int) -> list[int]:
        parents = self._model.body_parentid
        return [one for one in range(1, self._model.nbody) if parents[one] == body]

    def _below(self, body: int) -> Iterator[int]:
        yield body
        for child in self._children(body):
            yield from self._below(child)

    def _joints_of(self, body: int) -> list[int]:
        first, count = self._model.body_jntadr[body], self._model.body_jntnum[body]
        return list(range(first, first + count)) if count else []

    def _joints_below(self, body: int) -> list[int]:
        return [joint for one in self._below(body) for joint in self._moving(one)]

    def _moving(self, body: int) -> list[int]:
        """Its hinges and slides, play left out; none of a base that floats."""
        model = self._model
        if self._floats(body):
            return []
        moving = [one for one in self._joints_of(body) if model.jnt_type[one] in MOVING]
        return [one for one in moving if not self._is_play(one)]

    def _is_play(self, joint: int) -> bool:
        model = self._model
        hinge = model.jnt_type[joint] == mjtJoint.mjJNT_HINGE and model.jnt_limited[joint]
        return bool(hinge) and not self._motors(joint) and np.ptp(model.jnt_range[joint]) < PLAY_RAD

    def _motors(self, joint: int) -> list[int]:
        """Its actuators."""
        model = self._model
        return [
            one
            for one in range(model.nu)
            if model.actuator_trntype[one] == mjtTrn.mjTRN_JOINT
            and model.actuator_trnid[one][0] == joint
        ]

    def _name(self, kind: mjtObj, index: int) -> str:
        """As in the model; what has none gets its number."""
        return mujoco.mj_id2name(self._model, kind, index) or f"{kind.name[6:].lower()}_{index}"

    def _link_name(self, body: int) -> str:
        return "base_link" if body == 0 else self._name(mjtObj.mjOBJ_BODY, body)

    # Links and joints

    def _anchor(self, body: int) -> FloatArray:
        """(3,) where the frame of its link is: at its last joint [m]."""
        joints = self._moving(body)
        return np.array(self._model.jnt_pos[joints[-1]]) if joints else np.zeros(3)

    def _write_body(self, body: int, parent: str) -> None:
        """A body, and all that hangs on it.

        Args:
            parent: link that it hangs on; empty: it is the base.
        """
        model, name = self._model, self._link_name(body)
        place, rotation = np.zeros(3), np.eye(3)
        if parent:
            place = model.body_pos[body] - self._anchor(int(model.body_parentid[body]))
            rotation = _matrix(model.body_quat[body])
        joints, anchor = self._moving(body), np.zeros(3)
        self._loose += [
            self._name(mjtObj.mjOBJ_JOINT, one)
            for one in self._joints_of(body)
            if self._is_play(one)
        ]
        if parent and not joints:
            self._write_joint(f"{name}_fixed", "fixed", parent, name, place, rotation)
        for at, joint in enumerate(joints):
            last = at == len(joints) - 1
            child = name if last else f"{name}_{self._name(mjtObj.mjOBJ_JOINT, joint)}"
            if not last:
                ElementTree.SubElement(self._robot, "link", {"name": child})
            there = np.array(model.jnt_pos[joint])
            self._write_moving(joint, parent, child, place + rotation @ (there - anchor), rotation)
            parent, place, rotation, anchor = child, np.zeros(3), np.eye(3), there
        link = ElementTree.SubElement(self._robot, "link", {"name": name})
        self._write_inertial(link, body, anchor)
        self._write_shapes(link, body, anchor)
        for one in self._children(body):
            self._write_body(one, name)

    def _write_moving(
        self, joint: int, parent: str, child: str, place: FloatArray, rotation: FloatArray
    ) -> None:
        model, name = self._model, self._name(mjtObj.mjOBJ_JOINT, joint)
        axis = np.array(model.jnt_axis[joint])
        slides = model.jnt_type[joint] == mjtJoint.mjJNT_SLIDE
        # The body stands as it is written down where the joint is at its reference.
        reference = float(model.qpos0[model.jnt_qposadr[joint]])
        if slides:
            place = place - rotation @ axis * reference
        else:
            rotation = rotation @ pin.AngleAxis(-reference, axis).toRotationMatrix()
        limited = bool(model.jnt_limited[joint])
        kind = "prismatic" if slides else "revolute" if limited else "continuous"
        element = self._write_joint(name, kind, parent, child, place, rotation)
        ElementTree.SubElement(element, "axis", {"xyz": written(axis)})
        effort = self._believed(name, self._effort(joint), slides=slides)
        limit = {"effort": f"{effort:.6g}", "velocity": f"{SPEED:g}"}
        if limited or slides:
            low, high = (float(one) for one in model.jnt_range[joint])
            limit |= {"lower": f"{low:.9g}", "upper": f"{high:.9g}"}
        ElementTree.SubElement(element, "limit", limit)
        for one in range(model.neq):
            follows = (
                mjtEq(int(model.eq_type[one])) == mjtEq.mjEQ_JOINT and model.eq_obj1id[one] == joint
            )
            if follows and model.eq_obj2id[one] >= 0:
                leader = self._name(mjtObj.mjOBJ_JOINT, int(model.eq_obj2id[one]))
                offset, factor = model.eq_data[one][:2]
                ElementTree.SubElement(
                    element, "mimic",
                    {"joint": leader, "multiplier": f"{factor:.9g}", "offset": f"{offset:.9g}"},
                )  # fmt: skip

    def _believed(self, name: str, effort: float, *, slides: bool) -> float:
        """A joint's limit [N m or N], or what is put in for one that no motor has."""
        if effort > MOST_EFFORT_M * self._weight and not slides:
            self._endless.append(f"{name} {effort:.4g} N m")
            return EFFORT_M * self._weight
        if effort > 0.0:
            return effort
        self._weak.append(name)
        return EFFORT_M * self._weight

    def _effort(self, joint: int) -> float:
        """The largest torque or force that its motors have; 0 where it has no limit."""
        model = self._model
        if model.jnt_actfrclimited[joint]:
            return float(np.abs(model.jnt_actfrcrange[joint]).min())
        found = 0.0
        for one in self._motors(joint):
            gear = abs(float(model.actuator_gear[one][0]))
            if model.actuator_forcelimited[one]:
                found += gear * float(np.abs(model.actuator_forcerange[one]).min())
            elif model.actuator_ctrllimited[one] and not model.actuator_biasprm[one].any():
                gain = abs(float(model.actuator_gainprm[one][0]))
                found += gear * gain * float(np.abs(model.actuator_ctrlrange[one]).min())
        return found

    def _write_joint(
        self, name: str, kind: str, parent: str, child: str, place: FloatArray,
        rotation: FloatArray,
    ) -> ElementTree.Element:  # fmt: skip
        element = ElementTree.SubElement(self._robot, "joint", {"name": name, "type": kind})
        _write_origin(element, place, rotation)
        ElementTree.SubElement(element, "parent", {"link": parent})
        ElementTree.SubElement(element, "child", {"link": child})
        return element

    def _write_inertial(self, link: ElementTree.Element, body: int, anchor: FloatArray) -> None:
        model = self._model
        if not model.body_mass[body] > 0.0:
            return
        inertial = ElementTree.SubElement(link, "inertial")
        place = model.body_ipos[body] - anchor
        _write_origin(inertial, place, _matrix(model.body_iquat[body]))
        mass = {"value": f"{model.body_mass[body]:.12g}"}
        ElementTree.SubElement(inertial, "mass", mass)
        about = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
        for key, value in zip(("ixx", "iyy", "izz"), model.body_inertia[body], strict=True):
            about[key] = f"{value:.12g}"
        ElementTree.SubElement(inertial, "inertia", about)

    # Shapes and sensors

    def _write_shapes(self, link: ElementTree.Element, body: int, anchor: FloatArray) -> None:
        """Those that touch others; where none do, all."""
        model = self._model
        first, count = model.body_geomadr[body], model.body_geomnum[body]
        geoms = list(range(first, first + count)) if count else []
        touching = [one for one in geoms if model.geom_contype[one] or model.geom_conaffinity[one]]
        for geom in touching or geoms:
            place = model.geom_pos[geom] - anchor
            rotation = _matrix(model.geom_quat[geom])
            for shape, shift in self._shapes(geom):
                collision = ElementTree.SubElement(link, "collision")
                _write_origin(collision, place + rotation @ shift, rotation)
                ElementTree.SubElement(collision, "geometry").append(shape)

    def _shapes(self, geom: int) -> Iterator[tuple[ElementTree.Element, FloatArray]]:
        """URDF shapes of one geometry, and how far along its axes each is moved [m]."""
        model, middle = self._model, np.zeros(3)
        kind, size = mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
        if kind == mjtGeom.mjGEOM_MESH:
            yield self._mesh(int(model.geom_dataid[geom])), middle
        elif kind in (mjtGeom.mjGEOM_BOX, mjtGeom.mjGEOM_ELLIPSOID):
            yield ElementTree.Element("box", {"size": written(2.0 * size)}), middle
        elif kind == mjtGeom.mjGEOM_SPHERE:
            yield ElementTree.Element("sphere", {"radius": f"{size[0]:.9g}"}), middle
        elif kind in (mjtGeom.mjGEOM_CYLINDER, mjtGeom.mjGEOM_CAPSULE):
            radius, length = f"{size[0]:.9g}", f"{2.0 * size[1]:.9g}"
            yield ElementTree.Element("cylinder", {"radius": radius, "length": length}), middle
            if kind == mjtGeom.mjGEOM_CAPSULE:
                for end in (size[1], -size[1]):
                    shift = np.array([0.0, 0.0, end])
                    yield ElementTree.Element("sphere", {"radius": radius}), shift

    def _mesh(self, mesh: int) -> ElementTree.Element:
        """The convex hull of a mesh, as MuJoCo has it: it collides by that alone."""
        model = self._model
        file = f"{self._folder}/{mesh}_{self._name(mjtObj.mjOBJ_MESH, mesh)}.stl"
        file = file.replace(" ", "_")
        if file not in self._meshes:
            first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            points = np.array(model.mesh_vert[first : first + count], dtype=np.float64)
            self._meshes[file] = _stl(points)
        return ElementTree.Element("mesh", {"filename": f"package://{file}"})

    def _write_sensors(self) -> None:
        """Sites at which forces and torques are measured, as sensors of six axes."""
        model = self._model
        sites = {
            int(model.sensor_objid[one])
            for one in range(model.nsensor)
            if mjtSensor(int(model.sensor_type[one]))
            in (mjtSensor.mjSENS_FORCE, mjtSensor.mjSENS_TORQUE)
        }
        for site in sorted(sites):
            body = int(model.site_bodyid[site])
            if body not in self._bodies or body == self._base:
                continue
            name = f"{self._name(mjtObj.mjOBJ_SITE, site)}_force_torque"
            ElementTree.SubElement(self._robot, "link", {"name": name})
            self._write_joint(
                f"{name}_joint", "fixed", self._link_name(body), name,
                model.site_pos[site] - self._anchor(body), _matrix(model.site_quat[site]),
            )  # fmt: skip
            gazebo = ElementTree.SubElement(self._robot, "gazebo", {"reference": f"{name}_joint"})
            ElementTree.SubElement(gazebo, "sensor", {"name": name, "type": "force_torque"})


def _matrix(quaternion: FloatArray) -> FloatArray:
    """(3, 3) rotation of MuJoCo's quaternion w, x, y, z."""
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, np.asarray(quaternion, dtype=np.float64))
    return found.reshape(3, 3)


def _write_origin(element: ElementTree.Element, place: FloatArray, rotation: FloatArray) -> None:
    rpy = np.asarray(pin.rpy.matrixToRpy(np.asarray(rotation)))
    ElementTree.SubElement(element, "origin", {"xyz": written(place), "rpy": written(rpy)})


def _stl(points: FloatArray) -> bytes:
    """The convex hull of points (k, 3), binary; a box around those that have no volume."""
    try:
        triangles = points[ConvexHull(points).simplices]
    except QhullError:
        low, high = points.min(axis=0), points.max(axis=0)
        corners = np.array(
            [[(low, high)[one >> axis & 1][axis] for axis in range(3)] for one in range(8)]
        )
        sides = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
        sides += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        triangles = corners[np.array(sides)]
    packed = np.zeros(
        len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("_", "<u2")]
    )
    packed["corners"] = triangles
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + packed.tobytes()
