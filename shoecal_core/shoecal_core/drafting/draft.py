"""A robot file and a shoe file drafted from a URDF, and what of them is to be looked at."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body, read_body
from shoecal_core.drafting.capsules import DraftCapsule, find_capsules, pairs_of
from shoecal_core.drafting.closed_chains import held_joints
from shoecal_core.drafting.foot_cells import FootCells, find_cells
from shoecal_core.drafting.legs import UP, LegChains, find_legs
from shoecal_core.drafting.plausible import check_size, crossed_limits
from shoecal_core.drafting.posture import find_posture
from shoecal_core.drafting.six_axis import (
    SixAxis,
    at_ankles,
    elsewhere,
    find_six_axis,
    more_on_feet,
)
from shoecal_core.drafting.soles import (
    TOUCHING,
    Sole,
    SoleSize,
    find_sole,
    measured_sole,
    simplified,
)
from shoecal_core.drafting.support_range import DraftRange, find_range
from shoecal_core.errors import FileError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.joint_centres import own_joints
from shoecal_core.robot.link_shapes import Shapes, find_shapes
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import DEGREES_FROM, UrdfError, is_limitless
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

SENSING = (0.65, 0.6)
"""Length and width of the sensing polygon over the outline's, as on robots that are known: models
are off by some millimetres, and a foot that is loaded at its edge tips over it."""
CELL_INSET = 0.09
"""Part of a sole's length and width by which cells lie inside its bounds."""

ROLLS = 0.5
"""Cosine of the angle between the forward axis and one about which an ankle rolls, at least."""


@dataclass(frozen=True)
class Draft:
    """What was found in a robot's URDF.

    Attributes:
        name: of the robot.
        body, legs: as they were found.
        soles: left, right.
        posture: angles by joint [rad].
        capsules, pairs: shapes of the legs.
        support_range: of the right foot.
        six_axis: left, right; None where the foot has none.
        own_cells: left, right: cells in the robot's own soles; None where it has none, or six axes.
        other_sensors: six-axis sensors of the legs that are not used.
        parallel_sensors: of feet with several sensors, each of which carries a part of the load.
        missing_meshes: of the legs, each with what is the matter; their capsules are not known.
        held: joints that closed chains of links hold; none of the legs.
        measured: the soles' sizes were given, not found.
        keyframe: name of the posture that it was drafted in; empty: the zero pose.
    """

    name: str
    body: Body
    legs: LegChains
    soles: tuple[Sole, Sole]
    posture: dict[str, float]
    capsules: list[DraftCapsule]
    pairs: list[tuple[str, str]]
    support_range: DraftRange
    six_axis: list[SixAxis | None]
    own_cells: list[FootCells] | None
    other_sensors: list[str]
    parallel_sensors: list[str]
    missing_meshes: tuple[str, ...]
    held: tuple[str, ...]
    measured: bool
    keyframe: str = ""

    @property
    def mass(self) -> float:
        """Of the URDF's links [kg]."""
        return float(sum(inertia.mass for inertia in self.body.model.inertias))

    @property
    def leg_names(self) -> list[str]:
        """Joints of both legs that have motors of their own."""
        names = [str(self.body.model.names[joint]) for chain in self.legs.chains for joint in chain]
        return [name for name in names if name not in self.body.mimics]

    @property
    def weak_joints(self) -> list[str]:
        """Of the legs: without the effort or velocity limit that planning needs."""
        model = self.body.model
        places = {name: model.joints[model.getJointId(name)].idx_v for name in self.leg_names}
        return [
            name
            for name, place in places.items()
            if not (model.effortLimit[place] > 0.0 and model.velocityLimit[place] > 0.0)
        ]

    @property
    def strength(self) -> float:
        """Median torque limit of the legs' joints over the weight and the length of a leg."""
        model, hip = self.body.model, self.body.centres[self.legs.chains[0][0]]
        limits = [
            model.effortLimit[model.joints[model.getJointId(name)].idx_v] for name in self.leg_names
        ]
        length = float((hip - self.soles[0].in_base.translation) @ UP)
        return float(np.median(limits)) / (GRAVITY * self.mass * length)

    @property
    def ankles_roll(self) -> bool:
        """Whether one of the last two joints of each leg turns its foot about the forward axis."""
        return all(
            any(abs(self.body.axis(joint) @ self.legs.forward) > ROLLS for joint in chain[-2:])
            for chain in self.legs.chains
        )

    @property
    def crossed(self) -> list[str]:
        """Pairs of the legs' joints whose limits fit each other with the wrong sign."""
        names = self.body.model.names
        pairs = crossed_limits(self.body, self.legs)
        return [f"{names[left]} and {names[right]}" for left, right in pairs]

    @property
    def unlimited(self) -> list[str]:
        """Of the legs: joints that turn without limits in the URDF."""
        joints = self.body.root.iter("joint")
        limitless = {joint.get("name") for joint in joints if is_limitless(joint)}
        return [name for name in self.leg_names if name in limitless]

    @property
    def beyond_turns(self) -> list[str]:
        """Of the legs: joints whose limits are so many turns that they may be degrees."""
        return [
            str(self.body.model.names[joint])
            for chain in self.legs.chains
            for joint in chain
            if max(map(abs, self.body.range(joint))) > DEGREES_FROM
        ]

    @property
    def clipped(self) -> list[str]:
        """Joints other than the legs' that cannot be at zero."""
        legs = {joint for chain in self.legs.chains for joint in chain}
        return [
            str(self.body.model.names[joint])
            for joint in own_joints(self.body.model)
            if joint not in legs
            and self.body.start[joint] == 0.0
            and self.body.model.names[joint] in self.posture
        ]

    def polygon(self, foot: int) -> FloatArray:
        """(k, 2) sensing polygon of one foot: inside its outline, and between its cells [m]."""
        outline = shapely.Polygon(self.soles[foot].outline)
        inside: BaseGeometry = affinity.scale(outline, *SENSING)
        if self.six_axis[foot] is None:
            inside = inside.intersection(shapely.MultiPoint(self.cells(foot)).convex_hull)
        return simplified(inside)

    def cells(self, foot: int) -> FloatArray:
        """(k, 2) cells of one foot: its own, or one under each corner of the sole [m]."""
        if self.own_cells is not None:
            return np.round(self.own_cells[foot].places, 4)
        corners = self.soles[foot].outline
        outline = shapely.Polygon(corners)
        low, high = corners.min(axis=0), corners.max(axis=0)
        inset = CELL_INSET * (high - low)
        (back, right), (front, left) = low + inset, high - inset
        inner = outline.buffer(-0.05 * float((high - low).min()))
        places = [(front, left), (front, right), (back, left), (back, right)]
        kept = [nearest_points(inner, shapely.Point(place))[0] for place in places]
        return np.round([(point.x, point.y) for point in kept], 4)


def draft_robot(
    urdf: Path,
    name: str,
    *,
    six_axis: bool = False,
    sole: SoleSize | None = None,
    meshes: Path | None = None,
    keyframes: Mapping[str, Mapping[str, float]] | None = None,
) -> Draft:
    """Find legs, soles, posture, capsules and sensors in a URDF.

    Where they are not found in the zero pose, the keyframes are tried, in their order.

    Args:
        urdf: of the robot.
        name: of the robot.
        six_axis: the feet have six-axis sensors even where the URDF names none.
        sole: measured; None: found from the feet's shapes.
        meshes: folder of the meshes; None: where the URDF says, or near it.
        keyframes: postures by name, each with its angles by joint [rad].

    Raises:
        FileError: for a URDF that is no humanoid on two feet, without masses or limits, or without
            shapes of the feet where no sole was measured.
    """
    try:
        return _draft(read_body(urdf, meshes), name, sole, six_axis=six_axis)
    except FileError:
        for keyframe, angles in (keyframes or {}).items():
            try:
                body = read_body(urdf, meshes, angles)
                drafted = _draft(body, name, sole, six_axis=six_axis)
            except FileError:
                continue  # what is wrong with the zero pose is said
            return replace(drafted, keyframe=keyframe)
        raise


def _draft(body: Body, name: str, sole: SoleSize | None, *, six_axis: bool) -> Draft:
    """In the posture that the body is in."""
    legs = find_legs(body)
    held = held_joints(body, legs)
    check_size(body, legs)
    shapes = find_shapes(body, {joint for chain in legs.chains for joint in chain})
    soles = _soles(body, legs, shapes, sole)
    sensors = find_six_axis(body, legs, soles)
    if six_axis and None in sensors:
        sensors = at_ankles(body, legs, soles)
    if None in sensors:
        sensors = [None, None]
    capsules = find_capsules(body, legs, shapes.points, soles)
    return Draft(
        name=name,
        body=body,
        legs=legs,
        soles=soles,
        posture=find_posture(body, legs, soles),
        capsules=capsules,
        pairs=pairs_of(capsules),
        support_range=find_range(body, legs, soles, capsules),
        six_axis=sensors,
        own_cells=find_cells(body, legs, soles) if None in sensors else None,
        other_sensors=elsewhere(body, legs),
        parallel_sensors=more_on_feet(body, legs, soles),
        missing_meshes=tuple(sorted({file for one in shapes.missing.values() for file in one})),
        held=held,
        measured=sole is not None,
    )


def _soles(body: Body, legs: LegChains, shapes: Shapes, size: SoleSize | None) -> tuple[Sole, Sole]:
    """Left and right, measured or found."""
    found = []
    for chain, is_left in zip(legs.chains, (True, False), strict=True):
        foot = chain[-1]
        if size is not None:
            _check_height(body, foot, shapes, size)
            found.append(measured_sole(body, foot, size, legs.forward, is_left=is_left))
            continue
        if shapes.missing[foot]:
            raise UrdfError(
                body.urdf,
                f"its mesh {shapes.missing[foot][0]}, so its sole is not known; say where the "
                "meshes are (--mesh-dir), or measure the sole (--sole)",
                field=f"link {body.link(foot)[0]}",
            )
        found.append(find_sole(body, foot, shapes.points[foot], legs.forward))
    left, right = found
    _check_apart(body, left, right)
    return left, right


def _check_height(body: Body, foot: int, shapes: Shapes, size: SoleSize) -> None:
    """Refuse a measured sole that the foot's own shapes reach through."""
    points = shapes.points[foot]
    if not len(points):
        return
    ankle, placement = body.centres[foot], body.placements[foot]
    below = max(float((ankle - placement.act(point)) @ UP) for point in points)
    if below > size.height + TOUCHING:
        raise UrdfError(
            body.urdf,
            f"by it the ankle is {size.height:g} m above the floor, but by the shapes of "
            f"{body.link(foot)[0]} the foot reaches {below:.3f} m below the ankle; measure HEIGHT "
            "again, from the floor up to the ankle's axes",
            field="--sole",
        )


def _check_apart(body: Body, left: Sole, right: Sole) -> None:
    """Refuse soles that reach into each other: the URDF's meshes may be turned or mirrored."""
    outlines = []
    for sole in (left, right):
        corners = np.column_stack([sole.outline, np.zeros(len(sole.outline))])
        in_base = [left.in_base.actInv(sole.in_base.act(corner))[:2] for corner in corners]
        outlines.append(shapely.Polygon(in_base))
    if outlines[0].intersects(outlines[1]):
        length, width = 1e3 * np.ptp(left.outline, axis=0)
        raise UrdfError(
            body.urdf,
            f"by the shapes of the feet its soles are {length:.0f} mm long and {width:.0f} mm wide "
            "and overlap in the zero pose; turn the meshes, or measure the sole and give --sole",
            field=f"link {left.link}",
        )


def prove(draft: Draft, robot_text: str, shoe_text: str) -> tuple[Robot, Shoe]:
    """Load both files as every other command does, before they are written anywhere.

    Raises:
        FileError: when they do not load, with what must be corrected in the URDF.
    """
    with tempfile.TemporaryDirectory() as folder:
        robot, shoe = Path(folder, "robot.yaml"), Path(folder, "shoe.yaml")
        shoe.write_text(shoe_text, encoding="utf-8")
        robot.write_text(robot_text, encoding="utf-8")
        try:
            worn = load_shoe(shoe)
            return load_robot(robot, worn, urdf=draft.body.urdf), worn
        except FileError as error:
            raise UrdfError(
                draft.body.urdf,
                f"no robot file can be drafted from it: {error.field}: {error.problem}",
            ) from error


def relative(file: Path, folder: Path) -> str:
    """Path by which a file in `folder` names another one."""
    return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
