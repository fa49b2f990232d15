"""Figures of one planned motion."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.report.figures.cop_plan import Arrival, Carried, cop_plan
from shoecal_core.report.figures.margins import margins
from shoecal_core.report.figures.motion import SIDES, snapshots
from shoecal_core.report.figures.plane import FootShape
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.figures.support_plan import SupportPlan, Swing, support_plan
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import Look
from shoecal_core.report.plan_body import moved
from shoecal_core.report.plan_content import BOTH, PlannedMotion, Stand
from shoecal_core.report.quantities import quantity
from shoecal_core.robot.symbolic import joint_axis
from shoecal_core.shoe.shoe import FEET

FloatArray = NDArray[np.float64]

STILLS = 5
ROOT_JOINTS = 2
"""Pinocchio's universe and free-flyer stand before the robot's own joints."""
KEYS = tuple((Look(SIDES[side], 1.3), f"{FEET[side]} leg") for side in (0, 1))


def motion_pictures(planned: PlannedMotion) -> tuple[Picture, ...]:
    """All still figures of a motion, the most important one first."""
    return (
        Picture("Seen from above", above(planned), ABOVE),
        Picture("CoP against time", in_time(planned), "When the CoP comes to which landmark."),
        Picture("Margins kept", margins(planned.report.findings), MARGINS),
        Picture("Joint angles within their limits", angles(planned), ANGLES),
        Picture("Torques that hold the posture", torques(planned), TORQUES),
        Picture("On its way", stills(planned)),
    )


ABOVE = (
    "The robot faces upwards. A landmark counts as reached when the CoP (here: the CoM's ground "
    "projection) comes into its ring; one that is out of reach is left out, and its distance given."
)
MARGINS = (
    "The worst of the whole motion, tightest first, found by a check that is independent of the "
    "planner. A bar that ends at 100 % just keeps its limit."
)
ANGLES = "Each strip spans a joint's whole range. The dot marks where a limit is nearest."
TORQUES = (
    "By statics alone, from the model, as a part of each motor's own limit. Dashed: what planning "
    "allows; the rest is kept for heat and disturbances."
)


def above(planned: PlannedMotion) -> str:
    """The motion seen from above."""
    return support_plan(
        SupportPlan(
            feet=[shape_at(planned, foot, 0) for foot in (0, 1)],
            hulls=hulls(planned),
            marks=planned.marks,
            radius=planned.settings.landmark_radius,
            time=planned.motion.time,
            cop=planned.cop,
            swings=[
                swing(planned, stand) for stand in planned.stands if stand.feet != BOTH
            ],
        )
    )  # fmt: skip


def shape_at(planned: PlannedMotion, foot: int, sample: int) -> FootShape:
    """One foot from above, where it is at a sample."""
    shape = planned.robot.feet[foot]
    return FootShape(
        FEET[foot],
        placed(planned, foot, sample, shape.outline),
        placed(planned, foot, sample, shape.sensing_polygon),
        np.zeros((0, 2)),
    )


def placed(planned: PlannedMotion, foot: int, sample: int, points: FloatArray) -> FloatArray:
    """Points (k, 2) of a sole seen from above at a sample [m]."""
    rotation, place = planned.soles
    return points @ rotation[sample, foot, :2, :2].T + place[sample, foot, :2]


def hulls(planned: PlannedMotion) -> list[FloatArray]:
    """Corners (h, 2) of the hull of both sensing polygons, once for each double support [m]."""
    found: list[FloatArray] = []
    for stand in planned.stands:
        if stand.feet != BOTH:
            continue
        corners = [shape_at(planned, foot, stand.begin).sensing_polygon for foot in (0, 1)]
        hull = shapely.MultiPoint(np.vstack(corners)).convex_hull
        assert isinstance(hull, shapely.Polygon)
        ring = np.array(hull.exterior.coords)
        if not any(one.shape == ring.shape and np.allclose(one, ring, atol=1e-3) for one in found):
            found.append(ring)
    return found


def swing(planned: PlannedMotion, stand: Stand) -> Swing:
    """The way of the foot that does not carry."""
    foot = 1 - FEET.index(stand.feet)
    middle = planned.robot.feet[foot].outline.mean(axis=0)[None]
    samples = range(stand.begin, stand.end)
    way = np.vstack([placed(planned, foot, sample, middle) for sample in samples])
    return Swing(way, shape_at(planned, foot, stand.end - 1).outline)


def in_time(planned: PlannedMotion) -> str:
    """CoP, landmarks and carrying feet against time."""
    time = planned.motion.time
    return cop_plan(
        time,
        planned.cop,
        [
            Arrival(one.number, float(time[one.sample]), one.place, one.reached)
            for one in planned.targets
            if one.sample >= 0
        ],
        [
            Carried(stand.feet, float(time[stand.begin]), float(time[stand.end - 1]))
            for stand in planned.stands
        ],
    )


def angles(planned: PlannedMotion) -> str:
    """Leg joints between their limits."""
    robot, rows = planned.robot, []
    for index in robot.legs:
        linear, _ = joint_axis(robot.model, int(index) + ROOT_JOINTS)
        unit, scale = ("mm", 1e3) if np.any(linear) else ("°", 180.0 / np.pi)
        values = scale * planned.motion.positions[:, index]
        low, high = scale * robot.lower[index], scale * robot.upper[index]
        room = np.minimum(values - low, high - values)
        worst = int(np.argmin(room))
        rows.append(
            Strip(robot.joint_names[index], look_of(planned, index), values, low, high,
                  (), quantity(float(room[worst]), unit, 1), worst,
                  kept=bool(room[worst] >= 0.0))
        )  # fmt: skip
    return strips(planned.motion.time, rows, KEYS, "lower to upper joint limit", "nearest limit")


def torques(planned: PlannedMotion) -> str:
    """Holding torques as part of each motor's limit."""
    allowed = 100.0 * planned.settings.torque_share
    rows = []
    for column, index in enumerate(planned.robot.legs):
        values = 100.0 * np.abs(planned.torque_share[:, column])
        worst = int(np.argmax(values))
        rows.append(
            Strip(planned.robot.joint_names[index], look_of(planned, index), values, 0.0,
                  max(100.0, float(values[worst])), (allowed,),
                  quantity(float(values[worst]), "%", 0), worst,
                  kept=bool(values[worst] <= 100.0))
        )  # fmt: skip
    edges = f"0 to 100 % of the limit, {allowed:.0f} % dashed"
    return strips(planned.motion.time, rows, KEYS, edges, "peak")


def stills(planned: PlannedMotion) -> str:
    """Stick figures of a few instants."""
    time = planned.motion.time
    shown = np.linspace(0, len(time) - 1, STILLS).round().astype(int)
    return snapshots([moved(planned, int(sample)) for sample in shown], time[shown].tolist())


def look_of(planned: PlannedMotion, joint: int) -> Look:
    """By the leg that a joint belongs to."""
    model = planned.robot.model
    for side, foot in enumerate(planned.robot.feet):
        if joint + ROOT_JOINTS in list(model.supports[foot.joint]):
            return Look(SIDES[side], 1.3)
    return Look(SIDES[2], 1.3)
