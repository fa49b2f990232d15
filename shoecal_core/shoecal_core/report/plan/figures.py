"""Figures of one planned motion."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.report.figures.margins import margins
from shoecal_core.report.figures.motion import BODY, SIDES, Skeleton, leg_keys, skeleton, snapshots
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.figures.support_plan import support_plan
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import Look
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.quantities import quantity
from shoecal_core.robot.symbolic import joint_axis
from shoecal_core.robot.urdf import ROOT_JOINTS

STILLS = 5
ABOVE = (
    "The robot faces upwards. A landmark counts as reached when the CoP (here: the CoM's ground "
    "projection) comes into its ring; one that is out of reach is left out, and its distance given."
)
MARGINS = (
    "The worst of the whole motion, tightest first, found by a check that is independent of the "
    "planner. A bar that ends at its mark just keeps the limit."
)
ANGLES = "Each strip spans a joint's whole range. The dot marks where a limit is nearest."
TORQUES = (
    "By statics alone, from the model, as a part of each motor's own limit. Dashed: what planning "
    "allows; the rest is kept for heat and disturbances."
)


def moved(planned: PlannedMotion, sample: int) -> Skeleton:
    """The body in the world, from where the foot that carries stands."""
    stance = int(planned.stance[sample])
    body = skeleton(planned.robot, planned.motion.positions[sample], stance)
    turns, places = planned.soles
    turn, place = turns[sample, stance], places[sample, stance]

    def there(points: FloatArray) -> FloatArray:
        """(k, 3) points in the world [m]."""
        placed: FloatArray = points @ turn.T + place
        return placed

    return Skeleton(
        there(body.bones), body.side, (there(body.soles[0]), there(body.soles[1])),
        there(body.capsules), there(body.com),
    )  # fmt: skip


def motion_pictures(planned: PlannedMotion) -> tuple[Picture, ...]:
    """All still figures of a motion, the most important one first."""
    return (
        Picture("Seen from above", support_plan(planned), ABOVE),
        Picture("Margins kept", margins(planned.report.findings), MARGINS),
        Picture("Joint angles within their limits", angles(planned), ANGLES),
        Picture("Torques that hold the posture", torques(planned), TORQUES),
        Picture("On its way", stills(planned)),
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
            Strip(robot.joint_names[index], planned.motion.time,
                  ((look_of(planned, index), values),), low, high,
                  quantity(float(room[worst]), unit, 1), worst=worst,
                  kept=bool(room[worst] >= 0.0))
        )  # fmt: skip
    return strips(rows, leg_keys(), "lower to upper joint limit", "nearest limit")


def torques(planned: PlannedMotion) -> str:
    """Holding torques as part of each motor's limit."""
    allowed = 100.0 * planned.settings.torque_share
    rows = []
    for column, index in enumerate(planned.robot.legs):
        values = 100.0 * np.abs(planned.torque_share[:, column])
        worst = int(np.argmax(values))
        rows.append(
            Strip(planned.robot.joint_names[index], planned.motion.time,
                  ((look_of(planned, index), values),), 0.0, max(100.0, float(values[worst])),
                  quantity(float(values[worst]), "%", 0), limits=(allowed,), worst=worst,
                  kept=bool(values[worst] <= 100.0))
        )  # fmt: skip
    edges = f"0 to 100 % of the limit, {allowed:.0f} % dashed"
    return strips(rows, leg_keys(), edges, "peak")


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
            return SIDES[side]
    return SIDES[BODY]
