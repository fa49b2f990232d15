"""A robot's body as shapes: as much of each link as its mass requires, feet and shoes as they are.

Robot files carry no outer shapes that every robot has, so limbs are drawn as capsules between
joints, as thick as their mass makes them at one density. Only looks rest on this.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

Rgba = tuple[float, float, float, float]

ROUND = 20
"""Corners of what shall look round."""
ROOT = 1
"""Index of the floating base among the model's joints."""
DENSITY = 1300.0
"""kg/m^3: what a limb is drawn as thick as."""
SAME_PLACE = 0.005
"""m; joints nearer to each other than this are drawn as one."""
THINNEST = 0.006
"""m; what is thinner is not drawn."""
SHOE_HEIGHTS = (0.006, 0.05)
"""m; a sensor of another height is in the leg, not in a shoe."""

# Forces stand within the legs: they are to be seen through them.
LEFT: Rgba = (0.16, 0.47, 0.78, 0.45)
RIGHT: Rgba = (0.86, 0.42, 0.17, 0.45)
BODY: Rgba = (0.66, 0.70, 0.75, 1.0)
PLATE: Rgba = (0.27, 0.31, 0.36, 1.0)
CELL: Rgba = (0.88, 0.74, 0.30, 1.0)


@dataclass(frozen=True)
class LinkShape:
    """All points within `radius` of the convex hull of some points.

    One point makes a ball, two make a capsule; more must span a volume where the radius is 0.

    Attributes:
        points: (k, 3) in the world, z up [m].
        radius: [m].
        rgba: colour, each 0 to 1.
    """

    points: FloatArray
    radius: float
    rgba: Rgba

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not len(self.points):
            raise ShapeError("points of a shape", "(k, 3)", self.points.shape)


@dataclass(frozen=True)
class Joints:
    """Where the model's joints are with some joint angles, in the world, z up.

    Attributes:
        pose: of each.
        soles: of left and right sole.
        com: (3,) [m].
    """

    pose: tuple[pin.SE3, ...]
    soles: tuple[pin.SE3, pin.SE3]
    com: FloatArray


def joints_at(
    robot: Robot, joint_angles: FloatArray, stance: int = 0, pose: pin.SE3 | None = None
) -> Joints:
    """Forward kinematics.

    Args:
        robot: whose joints.
        joint_angles: (m,) [rad].
        stance: index of the foot that stands.
        pose: its sole frame in the world; None: the world is that sole frame.
    """
    if joint_angles.shape != (len(robot.joint_names),):
        raise ShapeError("joint angles", f"({len(robot.joint_names)},)", joint_angles.shape)
    model, data = robot.model, robot.model.createData()
    com = pin.centerOfMass(
        model, data, np.concatenate((pin.neutral(model)[:7], joint_angles))
    ).copy()
    soles = [data.oMi[foot.joint] * foot.placement for foot in robot.feet]
    here = (pin.SE3.Identity() if pose is None else pose) * soles[stance].inverse()
    return Joints(
        tuple(here * data.oMi[index] for index in range(model.njoints)),
        (here * soles[0], here * soles[1]),
        here.act(com),
    )


def body_shapes(
    robot: Robot, shoe: Shoe, at: Joints, *, cells: bool = True
) -> tuple[LinkShape, ...]:
    """Limbs, torso, head, feet and shoes, these with or without their cells."""
    shapes: list[LinkShape] = []
    for group in _groups(robot):
        side = _side(robot, group[0])
        feet = [foot for foot in (0, 1) if robot.feet[foot].joint in group]
        if feet:
            shapes += _foot(robot, shoe, at, feet[0], (LEFT, RIGHT)[side or 0], cells)
        else:
            shape = _link(robot, at, group, BODY if side is None else (LEFT, RIGHT)[side])
            shapes += [shape] if shape else []
    return tuple(shapes)


def _groups(robot: Robot) -> list[list[int]]:
    """The model's joints, those at one place together, from the root on."""
    model, groups = robot.model, {ROOT: [ROOT]}
    for joint in range(ROOT + 1, model.njoints):
        near = np.linalg.norm(model.jointPlacements[joint].translation) < SAME_PLACE
        home = groups[model.parents[joint]]
        # What sits on the torso's own origin is no part of the torso.
        if near and home[0] != ROOT:
            home.append(joint)
            groups[joint] = home
        else:
            groups[joint] = [joint]
    return list({id(group): group for group in groups.values()}.values())


def _side(robot: Robot, joint: int) -> int | None:
    """The leg that a joint belongs to."""
    for side, foot in enumerate(robot.feet):
        if joint != ROOT and joint in list(robot.model.supports[foot.joint]):
            return side
    return None


def _link(robot: Robot, at: Joints, group: list[int], rgba: Rgba) -> LinkShape | None:
    model = robot.model
    mass = sum(model.inertias[joint].mass for joint in group)
    place = at.pose[group[0]].translation
    ends = [
        at.pose[joint].translation
        for joint in range(ROOT + 1, model.njoints)
        if model.parents[joint] in group and joint not in group
    ]
    if group[0] == ROOT:
        return LinkShape(np.vstack((place, *ends)), 0.3 * math.cbrt(mass / DENSITY), rgba)
    if not ends:
        return _last(robot, at, group, mass, rgba)
    length = max(float(np.linalg.norm(end - place)) for end in ends)
    if length < SAME_PLACE:
        return None
    radius = min(math.sqrt(mass / (DENSITY * math.pi * length)), 0.5 * length)
    return LinkShape(np.vstack((place, *ends)), radius, rgba) if radius > THINNEST else None


def _last(robot: Robot, at: Joints, group: list[int], mass: float, rgba: Rgba) -> LinkShape | None:
    """What no joint follows: as far beyond its CoM as its joint is on the other side."""
    radius = math.cbrt(3.0 * mass / (4.0 * math.pi * DENSITY))
    if radius < THINNEST:
        return None
    place, com = at.pose[group[0]].translation, _com(robot, at, group)
    reach = float(np.linalg.norm(com - place))
    if reach < 1.5 * radius:
        return LinkShape(com[None], radius, rgba)
    return LinkShape(np.vstack((place, 2.0 * com - place)),
                 math.sqrt(mass / (DENSITY * math.pi * 2.0 * reach)), rgba)  # fmt: skip


def _com(robot: Robot, at: Joints, group: list[int]) -> FloatArray:
    inertias = robot.model.inertias
    moments = [inertias[one].mass * at.pose[one].act(inertias[one].lever) for one in group]
    com: FloatArray = sum(moments, np.zeros(3)) / sum(inertias[one].mass for one in group)
    return com


def _foot(
    robot: Robot, shoe: Shoe, at: Joints, index: int, rgba: Rgba, cells: bool
) -> list[LinkShape]:
    """The robot's foot, and the shoe under it: plates with cells between them."""
    foot, sole = robot.feet[index], at.soles[index]
    ankle = sole.inverse().act(at.pose[foot.joint].translation)
    low, high = SHOE_HEIGHTS
    worn = low < shoe.height < high
    floor = shoe.height if worn else 0.0
    rim = 0.3 * (ankle[2] - floor)
    inner = foot.outline.mean(axis=0) + 0.94 * (foot.outline - foot.outline.mean(axis=0))
    radius = 0.35 * float(np.ptp(foot.outline, axis=0).min())
    top = ankle - (0.0, 0.0, max(0.0, radius - 0.6 * (ankle[2] - floor)))
    round_top = np.column_stack((_disc(top[:2], radius), np.full(ROUND, top[2])))
    upper = np.vstack((_prism(inner, floor + 0.002, floor + rim), round_top))
    parts = [(upper, 0.0, rgba)]
    if worn:
        parts += [(_prism(foot.outline, 0.0, 0.25 * floor), 0.0, PLATE),
                  (_prism(foot.outline, 0.75 * floor, floor), 0.0, PLATE)]  # fmt: skip
        places = shoe.positions[shoe.of_foot(index)] if cells else np.zeros((0, 2))
        for cell in np.unique(places, axis=0):
            column = _prism(_disc(cell, 0.35 * floor), 0.25 * floor, 0.75 * floor)
            parts.append((column, 0.0, CELL))
    return [LinkShape(np.array([sole.act(one) for one in points]), round_, colour)
            for points, round_, colour in parts]  # fmt: skip


def _prism(outline: FloatArray, low: float, high: float) -> FloatArray:
    """Corners (2k, 3) over an outline (k, 2), between two heights [m]."""
    return np.vstack([np.column_stack((outline, np.full(len(outline), z))) for z in (low, high)])


def _disc(centre: FloatArray, radius: float) -> FloatArray:
    """Corners (ROUND, 2) of a circle about a place (2,) [m]."""
    angle = np.linspace(0.0, 2.0 * math.pi, ROUND, endpoint=False)
    return centre + radius * np.column_stack((np.cos(angle), np.sin(angle)))
