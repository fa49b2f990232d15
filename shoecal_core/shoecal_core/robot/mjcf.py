"""Corrections of a robot in a copy of its MJCF, made by MuJoCo's `MjSpec`.

MuJoCo turns a hinge by qpos - ref. An encoder that shows d too much is therefore `ref` + d: qpos,
keyframes and targets of servos stay in readings of encoders, and the link is where it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
from mujoco import mjtBias, mjtGain, mjtJoint, mjtObj, mjtSensor, mjtTrn

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.files import read_bytes
from shoecal_core.robot.correction import ModelCorrection
from shoecal_core.robot.mesh_files import LFS_POINTER
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.urdf import written
from shoecal_core.shoe.shoe import FEET

TURNED = 1e-3
"""rad; frames of one name in URDF and MJCF that differ by more are not the same frame."""
TRIED = 0.1
"""rad; angle of every joint at which frames are compared."""
PLAY_ARMATURE = 0.01
"""Of a joint with play, by the inertia that it turns: MuJoCo needs one on either side."""
_OLD = {
    "apirate", "collision", "convexhull", "exactmeshinertia", "mpr_iterations", "mpr_tolerance",
    "passive", "sensornoise",
}  # fmt: skip
"""Attributes of compiler, option and flag that MuJoCo had once."""
MOVING = (int(mjtJoint.mjJNT_HINGE), int(mjtJoint.mjJNT_SLIDE))
"""Types of joints with one angle or way."""
_FELT = (mjtSensor.mjSENS_FORCE, mjtSensor.mjSENS_TORQUE, mjtSensor.mjSENS_TOUCH)
_CURE = (
    "rename it there, or make robot file and URDF from this MJCF with `shoecal new robot`, and "
    "record with them"
)


class MjcfError(FileError):
    """An MJCF that no robot can be made of, or of another robot than the one in use."""


def read_mjcf(path: Path, lost: list[str] | None = None) -> tuple[mujoco.MjSpec, mujoco.MjModel]:
    """An MJCF as it is written down, and compiled.

    Args:
        path: of the file, whatever its suffix.
        lost: gets the mesh files that are not there, each with what is the matter; their shapes
            are left out. None: without one of them the model is not read.

    Raises:
        MjcfError: where MuJoCo does not read it, or the mass of a body follows from a lost mesh.
    """
    try:
        spec, whole = (_written_down(path) for _ in range(2))
        # Bodies that are fixed to others keep their names and numbers.
        whole.compiler.fusestatic = False
        # Pairs of contact often name the floor, which only the scene around the robot has.
        for pair in whole.pairs:
            whole.delete(pair)
        if lost is not None:
            lost += _without_lost_meshes(path, whole)
        return spec, whole.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise MjcfError(path, f"MuJoCo does not read it: {reason}; correct the model") from error


def _written_down(path: Path) -> mujoco.MjSpec:
    """MuJoCo goes by the suffix, which is not .xml everywhere, and knows no attributes of old."""
    text = read_bytes(path).decode("utf-8", errors="replace")
    try:
        if path.suffix.lower() == ".xml":
            return mujoco.MjSpec.from_file(str(path))
        spec = mujoco.MjSpec.from_string(text)
    except ValueError as error:
        if "unrecognized attribute" not in str(error):
            raise
        spec = mujoco.MjSpec.from_string(_without_old(text))
    spec.modelfiledir = str(path.parent)
    return spec


def _without_old(text: str) -> str:
    """An MJCF's text without settings that MuJoCo had once; no body or joint depends on them."""
    root = ElementTree.fromstring(text)  # noqa: S314 - MuJoCo read it as XML, and unfolds nothing
    for tag in ("compiler", "option", "flag"):
        for element in root.iter(tag):
            for name in _OLD & set(element.attrib):
                del element.attrib[name]
    return ElementTree.tostring(root, encoding="unicode")


def _without_lost_meshes(path: Path, spec: mujoco.MjSpec) -> list[str]:
    """Take shapes out whose meshes cannot be had; these, each with what is the matter."""
    folder = path.parent / spec.compiler.meshdir
    lost = {
        mesh.name: f"{mesh.file} {why}"
        for mesh in spec.meshes
        if mesh.file and (why := _trouble(folder / mesh.file))
    }
    for geom in list(spec.geoms):
        if geom.meshname not in lost:
            continue
        if not geom.parent.explicitinertial:
            raise MjcfError(
                path,
                f"its mass follows from a mesh, but {lost[geom.meshname]}; fetch the mesh, or give "
                "the body an <inertial>",
                field=f"body {geom.parent.name}",
            )
        spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name in lost:
            spec.delete(mesh)
    return list(lost.values())


def _trouble(mesh: Path) -> str:
    """What is the matter with a mesh file; empty where it is there."""
    if not mesh.is_file():
        return "is not there"
    content = read_bytes(mesh)
    if content.startswith(LFS_POINTER):
        return "is a Git LFS pointer (run git lfs pull)"
    return "" if content else "is empty"


def corrected_mjcf(
    path: Path, robot: Robot, correction: ModelCorrection
) -> tuple[str, tuple[str, ...]]:
    """An MJCF of the same robot with what was found, and in words what MuJoCo has no place for.

    Includes are unfolded; meshes and textures are named by absolute paths, so that the copy
    compiles in any folder. Mass properties become explicit where they change.

    Args:
        path: of the MJCF, whose joints and bodies have the names of the URDF's.
        robot: made of the URDF, without shoes.
        correction: of the robot.

    Raises:
        MjcfError: where MuJoCo does not read it, or a joint or body is missing, or turns
            otherwise than in the URDF.
    """
    return _Editor(path, robot, correction).edited()


class _Editor:
    """Edits one model.

    Attributes:
        left: what has no place, in words.
    """

    def __init__(self, path: Path, robot: Robot, correction: ModelCorrection) -> None:
        self._path, self._robot, self._correction = path, robot, correction
        self._spec, self._model = read_mjcf(path)
        self._per_radian = math.degrees(1.0) if self._spec.compiler.degree else 1.0
        self._exact: dict[str, FloatArray] = {}
        self.left: list[str] = []

    def edited(self) -> tuple[str, tuple[str, ...]]:
        """The text, and what has no place."""
        self._compare()
        for name, zero in self._correction.zeros.items():
            if zero != 0.0:
                self._move_zero(name, zero)
        self._weigh()
        for name, compliance in self._correction.compliance.items():
            self._soften(name, compliance)
        self._loosen()
        for foot, delay in self._correction.latency.items():
            self._delay(foot, delay)
        self._name_folders()
        self._spec.compile()
        return self._whole(self._spec.to_xml()), tuple(self.left)

    # Is it the same robot?

    def _compare(self) -> None:
        """Names, and the frames that have them, with every joint a little off its zero."""
        correction, robot = self._correction, self._robot
        given = (correction.zeros, correction.compliance, correction.play)
        joints = {name for names in given for name, value in names.items() if value != 0.0}
        for name in robot.joint_names:
            found = mujoco.mj_name2id(self._model, mjtObj.mjOBJ_JOINT, name)
            if name in joints and (found < 0 or int(self._model.jnt_type[found]) not in MOVING):
                raise self._missing(f"joint {name}", "hinge or slide")
        bodies = {name for name, factor in correction.masses.items() if factor != 1.0}
        bodies |= {name for name, shift in correction.coms.items() if np.any(shift)}
        for name in sorted(bodies):
            if mujoco.mj_name2id(self._model, mjtObj.mjOBJ_BODY, name) < 0:
                raise self._missing(f"body {name}", "body")
        self._compare_frames()

    def _missing(self, field: str, kind: str) -> MjcfError:
        problem = f"no {kind} has this name, which {self._robot.urdf.name} has; {_CURE}"
        return MjcfError(self._path, problem, field=field)

    def _compare_frames(self) -> None:
        robot, model, data = self._robot, self._model, mujoco.MjData(self._model)
        angles = np.clip(TRIED, robot.lower, robot.upper)
        for name, angle in zip(robot.joint_names, angles, strict=True):
            if mujoco.mj_name2id(model, mjtObj.mjOBJ_JOINT, name) >= 0:
                data.qpos[model.joint(name).qposadr[0]] = angle
        mujoco.mj_kinematics(model, data)
        state = robot.model.createData()
        pin.forwardKinematics(
            robot.model, state, np.concatenate((pin.neutral(robot.model)[:7], angles))
        )
        base: FloatArray | None = None
        for joint in range(1, robot.model.njoints):
            link = first_link(robot.model, joint)
            body = mujoco.mj_name2id(model, mjtObj.mjOBJ_BODY, link.name)
            if body < 0:
                continue
            there = state.oMi[joint].rotation @ link.placement.rotation
            off = data.xmat[body].reshape(3, 3) @ there.T
            base = off if base is None else base
            if np.linalg.norm(pin.log3(off @ base.T)) > TURNED:
                raise MjcfError(
                    self._path,
                    f"its frame is turned against that of the link in {robot.urdf.name}, or a "
                    "joint above it has another axis or zero; make both files from one source, "
                    "for example robot file and URDF from this MJCF with `shoecal new robot`",
                    field=f"body {link.name}",
                )

    # What MuJoCo has a place for

    def _move_zero(self, name: str, zero: float) -> None:
        joint = self._spec.joint(name)
        slides = joint.type == mjtJoint.mjJNT_SLIDE
        moved = zero if slides else zero * self._per_radian
        joint.ref += moved
        if np.any(joint.stiffness):
            joint.springref += moved  # a spring is at rest where its link is, not its encoder
        at = float(self._model.qpos0[self._model.joint(name).qposadr[0]])
        self._exact[f"joint {name}"] = np.array([at + zero])

    def _weigh(self) -> None:
        """Masses and CoMs; of a link, and of all that is fixed to it."""
        model, compiler = self._model, self._spec.compiler
        # Both would undo explicit masses, so that then all have to be explicit.
        by_geoms = compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
        whole = by_geoms or compiler.settotalmass > 0.0
        for index, body in enumerate(self._spec.bodies):
            if index == 0 or not model.body_mass[index] > 0.0:
                continue
            leading = self._leading(index)
            name = str(model.body(leading).name)
            factor = self._correction.masses.get(name, 1.0)
            shift = self._correction.coms.get(name, np.zeros(3))
            if factor == 1.0 and not np.any(shift) and not whole:
                continue
            turned = self._turn(index, leading) @ shift
            body.mass = float(model.body_mass[index]) * factor
            body.inertia = np.array(model.body_inertia[index]) * factor
            body.ipos = np.array(model.body_ipos[index]) + turned
            body.iquat = np.array(model.body_iquat[index])
            body.fullinertia = np.array([np.nan, 0.0, 0.0, 0.0, 0.0, 0.0])
            body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
            body.explicitinertial = True
            if body.name:
                self._exact[f"body {body.name}"] = np.array([body.mass, *body.ipos])
        if whole:
            compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
            compiler.settotalmass = -1.0

    def _leading(self, body: int) -> int:
        """The body that moves a body: itself, or the one that it is fixed to."""
        model = self._model
        while not model.body_jntnum[body] and model.body_parentid[body]:
            body = int(model.body_parentid[body])
        return body

    def _turn(self, body: int, leading: int) -> FloatArray:
        """(3, 3) from a leading body's frame into that of one that is fixed to it."""
        rotation = np.eye(3)
        while body != leading:
            found = np.zeros(9)
            mujoco.mju_quat2Mat(found, np.array(self._model.body_quat[body]))
            rotation = rotation @ found.reshape(3, 3).T
            body = int(self._model.body_parentid[body])
        return rotation

    def _soften(self, name: str, compliance: float) -> None:
        """Behind a servo: 1 / (1 / k + c) instead of its own stiffness k."""
        servos = [one for one in self._motors(name) if _is_servo(one)]
        for servo in servos:
            stiffness = float(servo.gainprm[0]) * float(servo.gear[0]) ** 2
            factor = 1.0 / (1.0 + compliance * stiffness)
            servo.gainprm[0] *= factor
            servo.biasprm[1] *= factor
        if not servos:
            self.left.append(
                f"compliance of {name}: MuJoCo has it in the gain of a position servo alone, and "
                "this joint has none"
            )

    def _motors(self, joint: str) -> Iterator[mujoco.MjsActuator]:
        for one in self._spec.actuators:
            if one.trntype == mjtTrn.mjTRN_JOINT and one.target == joint:
                yield one

    def _loosen(self) -> None:
        """Play as one more hinge behind the joint, free within its limits."""
        loose = {name: play for name, play in self._correction.play.items() if play > 0.0}
        model = self._model
        placed = []
        for name, play in loose.items():
            joint, there = self._spec.joint(name), model.joint(name)
            number = int(there.bodyid[0])
            last = int(model.body_jntadr[number] + model.body_jntnum[number]) - 1
            if joint.type != mjtJoint.mjJNT_HINGE or there.id != last:
                self.left.append(
                    f"play of {name}: only the last hinge of a body has a place for it"
                )
                continue
            body = joint.parent
            half = 0.5 * play * self._per_radian
            added = body.add_joint(
                name=f"{name}_play", type=mjtJoint.mjJNT_HINGE, axis=joint.axis, pos=joint.pos,
                limited=mujoco.mjtLimited.mjLIMITED_TRUE, range=[-half, half],
            )  # fmt: skip
            added.damping, added.stiffness = (
                0.0 * np.asarray(one) for one in (added.damping, added.stiffness)
            )
            added.frictionloss = 0.0
            added.ref = added.springref = 0.0
            added.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
            added.armature = PLAY_ARMATURE * float(model.dof_M0[int(there.dofadr[0])])
            placed.append((int(model.jnt_qposadr[last]) + 1, int(model.jnt_dofadr[last]) + 1))
        # From the last to the first, so that places before stay.
        for position, speed in sorted(placed, reverse=True):
            for key in self._spec.keys:
                for part, place in (("qpos", position), ("qvel", speed)):
                    values = np.array(list(getattr(key, part)))
                    if len(values) >= place:
                        setattr(key, part, np.insert(values, place, 0.0))

    def _delay(self, foot: str, delay: float) -> None:
        """Of sensors of force on a foot's link and what is fixed to it."""
        link = first_link(self._robot.model, self._robot.feet[FEET.index(foot)].joint)
        step, late = float(self._model.opt.timestep), []
        for one in self._spec.sensors:
            site = self._model.site(one.objname) if one.type in _FELT else None
            if (
                site is not None
                and self._model.body(self._leading(int(site.bodyid[0]))).name == link.name
            ):
                late.append(one)
        if delay <= 0.0 or not late or not hasattr(late[0], "delay"):
            why = "no force sensor on its link" if delay > 0.0 else "a reading from the future"
            self.left.append(f"latency of the {foot} foot: MuJoCo has no place for it ({why})")
            return
        for one in late:
            one.delay += delay
            one.nsample = max(int(one.nsample), math.ceil(float(one.delay) / step) + 1)

    # The file

    def _name_folders(self) -> None:
        """Assets by absolute folders."""
        compiler, here = self._spec.compiler, self._path.parent.resolve()
        for part in ("meshdir", "texturedir"):
            setattr(compiler, part, str((here / getattr(compiler, part)).resolve()))

    def _whole(self, text: str) -> str:
        """MuJoCo writes six digits; what was found is written with twelve."""
        root = ElementTree.fromstring(text)  # noqa: S314 - MuJoCo wrote it
        for element in root.iter():
            exact = self._exact.get(f"{element.tag} {element.get('name')}")
            inertial = element.find("inertial")
            if exact is None:
                continue
            if element.tag == "joint":
                element.set("ref", written(exact))
            elif inertial is not None:
                inertial.set("mass", written(exact[:1]))
                inertial.set("pos", written(exact[1:]))
        return ElementTree.tostring(root, encoding="unicode") + "\n"


def _is_servo(actuator: mujoco.MjsActuator) -> bool:
    """Whether its torque is a gain times the way to a target position."""
    fixed = actuator.gaintype == mjtGain.mjGAIN_FIXED
    affine = actuator.biastype == mjtBias.mjBIAS_AFFINE
    return bool(
        fixed and affine and actuator.gainprm[0] > 0.0
        and math.isclose(actuator.biasprm[1], -actuator.gainprm[0])
    )  # fmt: skip
