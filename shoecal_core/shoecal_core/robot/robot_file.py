"""Reading a robot file and its URDF."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import shapely

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import FieldError, FileMissingError
from shoecal_core.file_kinds import kind_of, meant, wanted
from shoecal_core.files import Fields, read_bytes, read_yaml, sha256
from shoecal_core.robot.joint_centres import centres_of, leg_length
from shoecal_core.robot.leg_links import UNLIKE, unlike_links
from shoecal_core.robot.plausible_links import check_links, read_links
from shoecal_core.robot.robot import (
    Capsule,
    Foot,
    JointDeflection,
    Robot,
    SharedMotor,
    SupportRange,
)
from shoecal_core.robot.shared_motors import read_shared_motors
from shoecal_core.robot.standing import check_standing
from shoecal_core.robot.urdf import ROOT_JOINTS, UrdfError, read_urdf
from shoecal_core.robot.weights import RobotWeights
from shoecal_core.shoe.shoe import FEET, Shoe

FORMAT = 1
SESSION_FILE, SESSION_URDF = "session.yaml", "robot.urdf"
"""What a session's folder is known by, and its copy of the URDF."""
KEYS = (
    "format", "name", "urdf", "weight", "feet", "legs", "shared_motors", "optional_joints",
    "posture_rad", "support_range", "capsules", "collision_pairs", "friction", "joint_deflection",
    "tilt_max_rad",
)  # fmt: skip
"""Of a robot file."""
MAX_LENGTH = 1.0
"""m; any foot that is larger was given in millimetres."""
FULL_TURN = 2.0 * np.pi
"""rad; larger angles were given in degrees."""
MAX_SUPPORTS = 1e6
"""Places of the right foot; more were meant to be fewer."""


def shoe_file_of(robot: Path) -> Path:
    """The shoe file that belongs to a robot file where none is named.

    That is `../shoes/ROBOT_shoe.yaml` as seen from the folder of `ROBOT.yaml`, or else
    `ROBOT_shoe.yaml` in that folder: there drafts are written.

    Raises:
        FileMissingError: when there is no such file.
        FileError: when the robot file cannot be read, or is a file of another kind.
    """
    # A robot file that is missing, or is another file, is reported as itself.
    if kind := kind_of(read_yaml(robot).keys(), KEYS):
        raise FieldError(robot, f"is {kind}, by its keys; {wanted(KEYS)}")
    folder = Path(os.path.normpath(robot.parent / ".." / "shoes"))
    shoe = folder / f"{robot.stem}_shoe.yaml"
    if not shoe.is_file():
        draft = robot.with_name(shoe.name)
        if draft.is_file():
            return draft
        raise FileMissingError(
            shoe,
            f"does not exist, and no other shoe belongs to {robot}; name one (--shoe, "
            "or the nodes' shoe_file)",
        )
    return shoe


def load_robot(
    path: Path,
    shoe: Shoe | None = None,
    *,
    urdf: Path | None = None,
    weight_kg: float | None = None,
) -> Robot:
    """Read ROBOT.yaml and its URDF; put the shoes on where there are any.

    Args:
        path: of the robot file.
        shoe: put on.
        urdf: taken instead of the one that the robot file names.
        weight_kg: taken instead of the robot file's, shoes included [kg].

    In a session's folder the URDF is the session's copy: the robot file there is the one that was
    recorded with, byte for byte, and names the URDF as it was called elsewhere.

    With shoes the sole frames are on the shoes' floor side, and the shoes' masses are part
    of the model.

    Raises:
        FileError: for anything missing, mistyped or impossible, naming file and field.
    """
    path = Path(path)
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(*KEYS)
    urdf = urdf or _urdf_of(fields)
    description = read_urdf(urdf)
    model = description.model
    weight = fields.mapping("weight")
    weight.only("mass_kg", "std_kg")
    mass = weight.number("mass_kg", above=0.0)
    mass_std = weight.number("std_kg", minimum=0.0)
    shoes = 0.0 if shoe is None else shoe.mass
    given = None if weight_kg is None else weight_kg - shoes
    declared = sum(inertia.mass for inertia in model.inertias)
    RobotWeights(declared, mass, mass_std, given, shoes).check(weight)
    mass = mass if given is None else given
    _scale_mass(model, mass)
    feet = _feet(fields.mapping("feet"), model, 0.0 if shoe is None else shoe.height)
    if shoe is not None:
        _put_on(model, feet, shoe)
        mass += shoe.mass
    names = list(model.names)[ROOT_JOINTS:]
    shared = read_shared_motors(fields, names, urdf, description.mimics)
    capsules = _capsules(fields, model)
    robot = Robot(
        name=fields.text("name"),
        path=path,
        digest=sha256(path),
        urdf=urdf,
        urdf_digest=sha256(urdf),
        model=model,
        mass=mass,
        mass_std=mass_std,
        feet=feet,
        legs=_legs(fields, model, names, shared, feet),
        shared=shared,
        posture=_posture(fields, model, names, shared),
        optional=frozenset(_known_joints(fields, "optional_joints", model, names)),
        capsules=capsules,
        collision_pairs=_pairs(fields, capsules),
        support_range=_support_range(fields.mapping("support_range")),
        friction=fields.number("friction", default=Robot.friction, above=0.0, maximum=2.0),
        deflection=_deflection(fields),
        tilt_max=fields.number("tilt_max_rad", default=Robot.tilt_max, above=0.0, maximum=1.5),
    )
    _check_links(robot)
    check_standing(robot, fields)
    for index in robot.between_feet:
        if robot.joint_names[index] in robot.optional:
            raise fields.error(
                "optional_joints",
                f"'{robot.joint_names[index]}' lies between the feet, whose places follow from its "
                "angle: record it, or make it 'fixed' in the URDF if it cannot move",
            )
    return robot


def _check_links(robot: Robot) -> None:
    """Refuse a URDF whose CoMs or masses have another unit, as exporters write them, or whose legs
    are unlike both in the zero pose and in the robot's posture.
    """
    model, legs = robot.model, robot.leg_chains
    zero, standing = pin.neutral(model), pin.neutral(model)
    standing[-len(robot.posture) :] = robot.posture
    length = leg_length(centres_of(model, _placements(model, zero)), legs[0])
    # read_urdf has refused document types, so no entity can unfold here.
    text = read_bytes(robot.urdf).decode("utf-8", errors="replace")
    check_links(robot.urdf, read_links(ElementTree.fromstring(text)), length)  # noqa: S314
    found = [unlike_links(model, _placements(model, pose), legs) for pose in (standing, zero)]
    unlike = [one for one in found if one is not None and one.off > UNLIKE * one.length]
    if len(unlike) == len(found):
        raise UrdfError(robot.urdf, unlike[-1].text, field="joint origins")


def _placements(model: pin.Model, pose: FloatArray) -> list[pin.SE3]:
    """Of every joint in the base."""
    data = model.createData()
    pin.forwardKinematics(model, data, pose)
    return [pin.SE3(placement) for placement in data.oMi]


def _urdf_of(fields: Fields) -> Path:
    """The URDF that a robot file names, or the session's copy of it."""
    folder, named = fields.path.parent, fields.text("urdf")
    if (folder / SESSION_FILE).is_file():
        return folder / SESSION_URDF
    urdf = folder / named
    if not urdf.exists():
        at = Path(os.path.normpath(urdf))
        same = folder / urdf.name
        near = f"did you mean '{urdf.name}'? " if same.is_file() else ""
        problem = f"there is no URDF at {at}; {near}give its path as seen from this robot file"
        raise FileMissingError(fields.path, problem, field="urdf")
    return urdf


def _scale_mass(model: pin.Model, mass: float) -> None:
    """Scale the URDF's masses to the weighed one: a CoM depends on their ratios only."""
    scale = mass / sum(inertia.mass for inertia in model.inertias)
    for index, inertia in enumerate(model.inertias):
        if inertia.mass > 0.0:
            # Set one by one: the constructor refuses published robots whose rotational inertia is
            # off by a rounding, and nothing here needs it.
            scaled = pin.Inertia(inertia)
            scaled.mass = inertia.mass * scale
            scaled.inertia = inertia.inertia * scale
            model.inertias[index] = scaled


def _feet(fields: Fields, model: pin.Model, shoe_height: float) -> tuple[Foot, Foot]:
    fields.only(*FEET)
    left, right = (_foot(fields.mapping(name), name, model, shoe_height) for name in FEET)
    if left.joint == right.joint:
        raise fields.mapping("right").error("link", "is the left foot's; name the right foot's")
    return left, right


def _foot(fields: Fields, name: str, model: pin.Model, shoe_height: float) -> Foot:
    fields.only("link", "sole_xyz_m", "sole_rpy_rad", "outline_m", "sensing_polygon_m")
    joint, link = _link(fields, "link", model)
    roll, pitch, yaw = fields.array("sole_rpy_rad", (3,))
    sole = pin.SE3(pin.rpy.rpyToMatrix(roll, pitch, yaw), fields.array("sole_xyz_m", (3,)))
    below = pin.SE3(np.eye(3), np.array([0.0, 0.0, -shoe_height]))
    placement = link * sole * below
    frame = model.addFrame(
        pin.Frame(f"{name}_sole", joint, placement, pin.FrameType.OP_FRAME), False
    )
    outline = _convex(fields, "outline_m")
    sensing = _convex(fields, "sensing_polygon_m")
    if not shapely.Polygon(outline).buffer(1e-6).contains(shapely.Polygon(sensing)):
        raise fields.error("sensing_polygon_m", "lies partly outside 'outline_m'; shrink it")
    own = model.getFrameId(fields.text("link"), pin.FrameType.BODY)
    return Foot(frame, own, joint, placement, outline, sensing)


def _convex(fields: Fields, key: str) -> FloatArray:
    """A convex polygon, returned counter-clockwise."""
    points = fields.array(key, (None, 2))
    if len(points) < 3:
        raise fields.error(key, "needs at least three corners")
    polygon = shapely.Polygon(points)
    if not polygon.is_valid or polygon.area < 1e-6:
        raise fields.error(key, "crosses itself or has no area; list the corners in order")
    if polygon.convex_hull.area - polygon.area > 1e-9:
        raise fields.error(key, "is not convex; list its convex hull")
    if np.abs(points).max() > MAX_LENGTH:
        raise fields.error(key, f"a corner lies over {MAX_LENGTH:g} m away; give metres")
    return points if polygon.exterior.is_ccw else points[::-1]


def _put_on(model: pin.Model, feet: tuple[Foot, Foot], shoe: Shoe) -> None:
    for foot, plates in zip(feet, shoe.plates, strict=True):
        for mass, com in (
            (plates.mass_above, plates.com_above),
            (plates.mass_below, plates.com_below),
        ):
            inertia = pin.Inertia(mass, com, np.zeros((3, 3)))
            model.appendBodyToJoint(foot.joint, inertia, foot.placement)


def _legs(
    fields: Fields,
    model: pin.Model,
    names: list[str],
    shared: tuple[SharedMotor, ...],
    feet: tuple[Foot, Foot],
) -> IntArray:
    legs = _known_joints(fields, "legs", model, names)
    if len(legs) < 6:
        raise fields.error("legs", f"{len(legs)} joints cannot keep two feet in place")
    leaders = {names[motor.joint]: names[motor.leader] for motor in shared}
    for name in legs:
        if legs.count(name) > 1:
            raise fields.error("legs", f"'{name}' must stand once")
        if name in leaders:
            raise fields.error(
                "legs", f"'{name}' turns with '{leaders[name]}'; leave it out, name that one"
            )
    moved = {*legs, *(follower for follower, leader in leaders.items() if leader in legs)}
    for side, foot in zip(FEET, feet, strict=True):
        chain = [model.names[index] for index in model.supports[foot.joint]][ROOT_JOINTS:]
        if moved.isdisjoint(chain):
            raise fields.error(
                "legs", f"none of them moves the {side} foot; name its leg's: {', '.join(chain)}"
            )
    return np.array([names.index(name) for name in legs])


def _known_joints(fields: Fields, key: str, model: pin.Model, names: list[str]) -> list[str]:
    found = fields.texts(key) if key in fields else []
    for name in found:
        if name not in names:
            raise fields.error(key, _unknown(name, model, names))
    return found


def _unknown(name: str, model: pin.Model, names: list[str]) -> str:
    """Why a name is that of no joint which moves, with the cure."""
    if model.existFrame(name, pin.FrameType.FIXED_JOINT):
        return (
            f"joint '{name}' is fixed in the URDF, by its type or by limits that are one angle; "
            "give it type revolute and its limits there, or leave it out here"
        )
    return f"the URDF has no joint '{name}'; {meant(name, names)}"


def _deflection(fields: Fields) -> JointDeflection:
    usual = JointDeflection()
    if "joint_deflection" not in fields:
        return usual
    block = fields.mapping("joint_deflection")
    block.only("sag_rad", "play_rad")
    return JointDeflection(
        sag=block.number("sag_rad", default=usual.sag, above=0.0, maximum=0.5),
        play=block.number("play_rad", default=usual.play, minimum=0.0, maximum=0.2),
    )


def _posture(
    fields: Fields, model: pin.Model, names: list[str], shared: tuple[SharedMotor, ...]
) -> FloatArray:
    block = fields.mapping("posture_rad")
    posture = np.zeros(len(names))
    for name in block.keys():
        if name not in names:
            raise block.error(name, _unknown(name, model, names))
        posture[names.index(name)] = block.number(name)
    for motor in shared:
        follower = motor.ratio * posture[motor.leader]
        if names[motor.joint] in block and abs(posture[motor.joint] - follower) > 1e-6:
            raise block.error(
                names[motor.joint],
                f"turns with '{names[motor.leader]}', so it is {follower:g} rad; leave it out",
            )
        posture[motor.joint] = follower
    for name, value, low, high in zip(
        names, posture, model.lowerPositionLimit[7:], model.upperPositionLimit[7:], strict=True
    ):
        if not low <= value <= high:
            degrees = low <= np.radians(value) <= high and abs(value) > FULL_TURN
            cure = f"; give rad, not degrees: {np.radians(value):.3g}" if degrees else ""
            raise block.error(
                name, f"{value:g} lies outside the joint's {low:g} to {high:g} rad{cure}"
            )
    return posture


def _link(fields: Fields, key: str, model: pin.Model) -> tuple[int, pin.SE3]:
    """Joint that carries a link, and the link's frame in that joint's frame."""
    name = fields.text(key)
    links = [frame.name for frame in model.frames if frame.type == pin.FrameType.BODY]
    if name not in links:
        raise fields.error(key, f"the URDF has no link '{name}'; {meant(name, links)}")
    frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
    return int(frame.parentJoint), frame.placement


def _capsules(fields: Fields, model: pin.Model) -> tuple[Capsule, ...]:
    capsules = []
    for item in fields.items("capsules") if "capsules" in fields else []:
        item.only("name", "link", "from_m", "to_m", "radius_m")
        joint, link = _link(item, "link", model)
        capsules.append(
            Capsule(
                name=item.text("name"),
                joint=joint,
                start=link.act(item.array("from_m", (3,))),
                end=link.act(item.array("to_m", (3,))),
                radius=item.number("radius_m", above=0.0, maximum=MAX_LENGTH),
            )
        )
        if capsules[-1].name in [capsule.name for capsule in capsules[:-1]]:
            raise item.error("name", f"'{capsules[-1].name}' appears twice; give each its own")
    return tuple(capsules)


def _pairs(fields: Fields, capsules: tuple[Capsule, ...]) -> tuple[tuple[int, int], ...]:
    names = [capsule.name for capsule in capsules]
    pairs = []
    for item in fields.items("collision_pairs") if "collision_pairs" in fields else []:
        item.only("a", "b")
        a, b = (item.choice(key, dict.fromkeys(names)) for key in ("a", "b"))
        if a == b:
            raise item.error("b", f"'{b}' cannot keep a distance to itself; name another capsule")
        pair = (names.index(a), names.index(b))
        if capsules[pair[0]].joint == capsules[pair[1]].joint:
            raise item.error(
                "b", f"'{b}' and '{a}' move together, their distance never changes; drop the pair"
            )
        pairs.append(pair)
    return tuple(pairs)


def _support_range(fields: Fields) -> SupportRange:
    fields.only("dx_m", "dy_m", "dtheta_rad")
    rows = []
    for key in ("dx_m", "dy_m", "dtheta_rad"):
        axis = fields.mapping(key)
        axis.only("lower", "upper", "step", "neutral")
        lower, upper = axis.number("lower"), axis.number("upper")
        if lower > upper:
            raise axis.error("lower", f"{lower:g} is above 'upper' ({upper:g})")
        neutral = axis.number("neutral", minimum=lower, maximum=upper)
        rows.append((lower, upper, axis.number("step", above=0.0), neutral))
    lower_, upper_, step, neutral_ = np.array(rows).T
    count = np.prod(np.floor((upper_ - lower_) / step) + 1.0)
    if count > MAX_SUPPORTS:
        finest = ("dx_m", "dy_m", "dtheta_rad")[int(np.argmax((upper_ - lower_) / step))]
        raise fields.mapping(finest).error(
            "step", f"the range would have {count:.2g} places of the right foot; enlarge the step"
        )
    return SupportRange(lower_, upper_, step, neutral_)
