"""A motion as a stick figure that can be animated: from the right and from the front."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.body_points import (
    HEADING,
    BodyPoints,
    document,
    scale_bar,
    shape,
    sole,
    time_label,
)
from shoecal_core.report.figures.motion import BODY, LEFT_SIDE, RIGHT_SIDE, SIDES
from shoecal_core.report.palette import Colour
from shoecal_core.report.player import PlayerView
from shoecal_core.report.svg import WIDTH

FloatArray = NDArray[np.float64]

TOP, FLOOR, GAP = 40.0, 14.0, 12.0
TALLEST = 300.0


def from_the_side(motion_points: BodyPoints, still: int, label: str) -> str:
    """The whole body from its right, and from its front, at one frame.

    Args:
        motion_points: of the motion.
        still: the frame that is drawn.
        label: time of that frame.
    """
    low, high = _extent(motion_points)
    span, width = high - low, (WIDTH - GAP) / 2.0
    scale = min((width - 8.0) / max(span[0], span[1]), TALLEST / span[2])
    floor = TOP + scale * high[2]
    height = floor + FLOOR - scale * low[2]
    parts = []
    for panel, (across, name) in enumerate(((0, "from the right"), (1, "from the front"))):
        left = panel * (width + GAP)
        middle = left + width / 2.0 - scale * (low[across] + high[across]) / 2.0
        view = PlayerView((across, 2), (scale, -scale), (middle, floor))
        parts.append(
            f'<text x="{left:g}" y="{TOP - 8:g}" class="s m">{name}</text>'
            f'<path d="M{left:g} {floor:g}H{left + width:g}" class="f"/>'
            f'<g data-view="{view.attribute}">{_body(motion_points, view, still, scale)}</g>'
        )
    parts.append(scale_bar(WIDTH - 4.0, height - 3.0, scale))
    alt = f"Stick figure of the robot from its right and from its front, {label}."
    return document(height, _keys(label) + "".join(parts), alt)


def _extent(motion_points: BodyPoints) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y, z) of all that is drawn, the floor included."""
    points = motion_points.points.reshape(-1, 3)
    low, high = np.append(points, [[np.inf, np.inf, 0.0]], axis=0).min(axis=0), points.max(axis=0)
    for start, end, radius in motion_points.capsules:
        ends = motion_points.points[:, [start, end]].reshape(-1, 3)
        low[:2] = np.minimum(low, ends.min(axis=0) - radius)[:2]
        high = np.maximum(high, ends.max(axis=0) + radius)
    return low, high


def _body(motion_points: BodyPoints, view: PlayerView, frame: int, scale: float) -> str:
    drawn = []
    for a, b, radius in motion_points.capsules:
        drawn.append(shape("bones", (a, b), motion_points, view, frame,
                            f'class="c" stroke-width="{2 * radius * scale:.1f}"'))  # fmt: skip
    drawn += [
        sole(side, "o", motion_points, view, frame, f' style="{_paint(SIDES[side])}"')
        for side in (LEFT_SIDE, RIGHT_SIDE)
    ]
    for side in (BODY, RIGHT_SIDE, LEFT_SIDE):
        if not motion_points.bones[side]:
            continue
        style = f'class="b" style="stroke:var(--{SIDES[side].name})"'
        drawn.append(shape("bones", motion_points.bones[side], motion_points, view, frame, style))
    drawn.append(
        shape(
            "bones", (motion_points.com, motion_points.cop), motion_points, view, frame, 'class="d"'
        )
    )
    drawn.append(shape("dot", (motion_points.com,), motion_points, view, frame, 'r="4" class="k"'))
    drawn.append(
        shape("dot", (motion_points.cop,), motion_points, view, frame, 'r="3.5" class="p"')
    )
    return "".join(drawn)


def _paint(colour: Colour) -> str:
    return f"stroke:var(--{colour.name});fill:var(--{colour.name})"


def _keys(label: str) -> str:
    names = [(SIDES[0].name, "left leg"), (SIDES[1].name, "right leg"), (SIDES[2].name, "body")]
    drawn, x, y = [], 0.0, HEADING
    for colour, name in names:
        drawn.append(
            f'<path d="M{x:g} {y - 3:g}h14" class="b" style="stroke:var(--{colour})"/>'
            f'<text x="{x + 18:g}" y="{y:g}" class="s">{name}</text>'
        )
        x += 28.0 + 5.2 * len(name)
    drawn.append(
        f'<circle cx="{x + 5:g}" cy="{y - 3:g}" r="4" class="k"/>'
        f'<text x="{x + 13:g}" y="{y:g}" class="s">CoM</text>'
        f'<circle cx="{x + 46:g}" cy="{y - 3:g}" r="3.5" class="p"/>'
        f'<text x="{x + 54:g}" y="{y:g}" class="s">CoP</text>'
    )
    return "".join(drawn) + time_label(label)
