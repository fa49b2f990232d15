"""The robot's motion as stick figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShapeError
from shoecal_core.report.palette import FEET, MUTED, PLAIN, RULE, Look
from shoecal_core.report.svg import SMALL, WIDTH, canvas, draw_line, line_key
from shoecal_core.robot.robot import Robot

LEFT_SIDE, RIGHT_SIDE, BODY = 0, 1, 2
SIDES: tuple[Look, ...] = (*FEET, Look(PLAIN, 1.3))
LIFTED = 0.01
"""m; a sole further above the other than this does not stand."""
ROOT = 1
"""Index of the floating base among the model's joints."""


@dataclass(frozen=True)
class Skeleton:
    """A robot at one instant, in the frame of the sole it stands on, z up.

    Attributes:
        bones: (b, 2, 3) from joint to joint [m].
        side: (b,) LEFT_SIDE, RIGHT_SIDE for the legs, else BODY.
        soles: outlines (k, 3) of the left and the right sole [m].
        capsules: (c, 2, 3) ends of the robot's capsules, in its order [m].
        com: (3,) centre of mass [m].
    """

    bones: FloatArray
    side: IntArray
    soles: tuple[FloatArray, FloatArray]
    capsules: FloatArray
    com: FloatArray


def skeleton(robot: Robot, joint_angles: FloatArray, stance: int | None = None) -> Skeleton:
    """Stick figure of a robot with joint angles (m,) [rad].

    Args:
        robot: whose joints.
        joint_angles: all of them.
        stance: index of the foot in whose sole frame it is; None: the left one, the right one
            while the left is lifted.
    """
    if joint_angles.shape != (len(robot.joint_names),):
        raise ShapeError("joint angles", f"({len(robot.joint_names)},)", joint_angles.shape)
    model = robot.model
    data = model.createData()
    configuration = np.concatenate((pin.neutral(model)[:7], joint_angles))
    com = pin.centerOfMass(model, data, configuration)
    poses = [data.oMi[foot.joint] * foot.placement for foot in robot.feet]
    if stance is None:
        stance = int((poses[0].inverse() * poses[1]).translation[2] < -LIFTED)
    to_floor = poses[stance].inverse()
    places = np.array([to_floor.act(data.oMi[index].translation) for index in range(model.njoints)])
    legs = [list(model.supports[foot.joint]) for foot in robot.feet]
    bones, sides = [], []
    for joint in range(ROOT + 1, model.njoints):
        bones.append((places[model.parents[joint]], places[joint]))
        sides.append(next((side for side in (0, 1) if joint in legs[side]), BODY))
    soles = []
    for side, (foot, pose) in enumerate(zip(robot.feet, poses, strict=True)):
        here = to_floor * pose
        outline = np.column_stack((foot.outline, np.zeros(len(foot.outline))))
        soles.append(np.array([here.act(corner) for corner in outline]))
        bones.append((places[foot.joint], here.act(np.append(foot.outline.mean(axis=0), 0.0))))
        sides.append(side)
    capsules = np.zeros((len(robot.capsules), 2, 3))
    for capsule, ends in zip(robot.capsules, capsules, strict=True):
        here = to_floor * data.oMi[capsule.joint]
        ends[:] = here.act(capsule.start), here.act(capsule.end)
    return Skeleton(
        np.array(bones), np.array(sides), (soles[0], soles[1]), capsules, to_floor.act(com)
    )


def snapshots(skeletons: Sequence[Skeleton], times: Sequence[float]) -> str:
    """Instants side by side: from the robot's right above, from its front below.

    The dashed line leads from the CoM to its ground projection.
    """
    top, gap = 36.0, 18.0
    width = WIDTH / len(skeletons)
    low, high = _extent(skeletons)
    span = high - low
    scale = min(0.92 * width / max(span[0], span[1]), 150.0 / span[2])
    height = scale * span[2]
    with canvas(top + 2 * height + gap + 16.0) as page:
        page.legend([*leg_keys(), _com_key()], left=0.0)
        for view, across in enumerate((0, 1)):
            panel_top = top + view * (height + gap)
            axes = page.panel(panel_top, height, left=0.0, right=WIDTH)
            axes.set_axis_off()
            axes.axhline(0.0, color=RULE.light, linewidth=0.8)
            for index, body in enumerate(skeletons):
                _draw(axes, body, across, shift=index * width / scale)
            middle = (low[across] + high[across]) / 2.0
            start = middle - width / scale / 2.0
            axes.set_xlim(start, start + WIDTH / scale)
            axes.set_ylim(low[2], high[2])
            page.write(2.0, panel_top - 3.0, ("from the right", "from the front")[view],
                       fontsize=SMALL, color=MUTED.light)  # fmt: skip
        for index, time in enumerate(times):
            page.write((index + 0.5) * width, top + 2 * height + gap + 13.0, f"{time:.1f} s",
                       ha="center", fontsize=SMALL)  # fmt: skip
        when = ", ".join(f"{time:.1f}" for time in times)
        return page.svg(f"Stick figures of the robot with its CoM at {when} s.")


def _extent(skeletons: Sequence[Skeleton]) -> tuple[FloatArray, FloatArray]:
    points = np.concatenate(
        [np.vstack((body.bones.reshape(-1, 3), *body.soles)) for body in skeletons]
    )
    margin = 0.03 * np.ptp(points[:, 2])
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def _draw(axes: Axes, body: Skeleton, across: int, shift: float) -> None:
    for side in (BODY, LEFT_SIDE, RIGHT_SIDE):
        bones = body.bones[body.side == side][:, :, (across, 2)]
        # A break of NaN between bones makes one line of each side.
        breaks = np.full((len(bones), 1, 2), np.nan)
        x, y = np.concatenate((bones, breaks), axis=1).reshape(-1, 2).T
        width = 1.6 if side == BODY else 2.2
        draw_line(axes, x + shift, y, replace(SIDES[side], width=width))
    for side, sole in enumerate(body.soles):
        axes.fill(sole[:, across] + shift, sole[:, 2], facecolor=SIDES[side].colour.light,
                  edgecolor=SIDES[side].colour.light, linewidth=1.6)  # fmt: skip
    x, height = body.com[across] + shift, body.com[2]
    axes.plot((x, x), (0.0, height), color=MUTED.light, linewidth=0.8, linestyle=(0, (3, 2)))
    axes.plot((x,), (height,), "o", color=MUTED.light, markersize=5.0)


def leg_keys() -> list[Line2D]:
    """Legend entries of both legs."""
    return [
        line_key(replace(SIDES[side], width=2.2), label)
        for side, label in ((LEFT_SIDE, "left leg"), (RIGHT_SIDE, "right leg"))
    ]


def _com_key() -> Line2D:
    return Line2D([], [], color=MUTED.light, linewidth=0.8, linestyle=(0, (3, 2)), marker="o",
                  markersize=5.0, label="CoM and its ground projection")  # fmt: skip
