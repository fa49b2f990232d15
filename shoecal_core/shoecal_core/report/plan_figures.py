"""Figures and animation of one planned motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.body_points import BodyPoints, body_points
from shoecal_core.report.figures.margins import margins
from shoecal_core.report.figures.motion import SIDES, Skeleton, leg_keys, skeleton, snapshots
from shoecal_core.report.figures.player_views import Ground, from_above, from_the_side
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.figures.support_plan import support_plan
from shoecal_core.report.page import Picture, Player
from shoecal_core.report.palette import Look
from shoecal_core.report.plan_content import BOTH, PlannedMotion
from shoecal_core.report.player import PlayerFrames
from shoecal_core.report.quantities import quantity
from shoecal_core.robot.symbolic import joint_axis

FloatArray = NDArray[np.float64]
STILLS = 5
ROOT_JOINTS = 2
"""Pinocchio's universe and free-flyer stand before the robot's own joints."""
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
RATE = 10.0
"""Frames a second: motions are slow, and between frames the page interpolates."""
CAPTION = (
    "Computed from the model: nothing was measured. The robot moves slowly; 4× is a good speed to "
    "look at."
)
IN_THE_AIR = "Soles with a dashed outline are in the air."


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


def polygons(planned: PlannedMotion, sample: int) -> tuple[FloatArray, FloatArray]:
    """Corners (c, 3) of each foot's sensing polygon at a sample, in the world [m]."""
    turns, places = planned.soles
    left, right = (
        np.column_stack((foot.sensing_polygon, np.zeros(len(foot.sensing_polygon))))
        @ turns[sample, side].T
        + places[sample, side]
        for side, foot in enumerate(planned.robot.feet)
    )
    return left, right


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
            return Look(SIDES[side], 1.3)
    return Look(SIDES[2], 1.3)


def animation(planned: PlannedMotion) -> Player:
    """The motion as stick figures and from above, with a still of its middle."""
    time = planned.motion.time
    count = max(2, int(np.ceil(planned.motion.duration * RATE)) + 1)
    samples = np.round(np.linspace(0, len(time) - 1, count)).astype(int)
    motion_points = body_points(
        [moved(planned, sample) for sample in samples],
        [polygons(planned, sample) for sample in samples],
        [capsule.radius for capsule in planned.robot.capsules],
        lifted(planned, samples),
    )
    still = count // 2
    moment = round(float(time[samples[still]]), 1)
    label = f"{moment:.1f} s"
    ground = Ground(planned.hulls, planned.marks, planned.settings.landmark_radius)
    return Player(
        title="The motion",
        svgs=(
            from_the_side(motion_points, still, label),
            from_above(motion_points, ground, still, label),
        ),
        frames=frames(planned, motion_points).to_json(),
        duration=round(planned.motion.duration, 1),
        still=moment,
        caption=f"{CAPTION} {IN_THE_AIR}" if motion_points.lifted.strip("-") else CAPTION,
    )


def frames(planned: PlannedMotion, motion_points: BodyPoints) -> PlayerFrames:
    """Points of the body in mm, those of CoM and CoP a digit finer."""
    decimals = [0] * motion_points.points.shape[1]
    decimals[motion_points.com] = decimals[motion_points.cop] = 1
    return PlayerFrames(
        planned.motion.duration, motion_points.points, motion_points.lifted, tuple(decimals)
    )


def lifted(planned: PlannedMotion, samples: NDArray[np.int64]) -> str:
    """A letter for each of the samples (k,): the foot in the air, `-` for none."""
    letters = np.full(len(planned.motion.time), "-")
    for stand in planned.stands:
        if stand.feet != BOTH:
            letters[stand.begin : stand.end] = "r" if stand.feet == "left" else "l"
    return "".join(letters[samples])
