"""A motion that can be animated: a stick figure from two sides, and the feet from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.body_points import (
    HEADING,
    BodyPoints,
    area,
    document,
    flat,
    line,
    scale_bar,
    shape,
    sole,
    time_label,
)
from shoecal_core.report.figures.motion import BODY, LEFT_SIDE, RIGHT_SIDE, SIDES
from shoecal_core.report.palette import Colour
from shoecal_core.report.plan_content import TargetMark
from shoecal_core.report.player import PlayerView
from shoecal_core.report.svg import WIDTH

FloatArray = NDArray[np.float64]
TOP, FLOOR, GAP = 40.0, 14.0, 12.0
TALLEST = 300.0
TOP_ABOVE = 32.0


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


@dataclass(frozen=True)
class Ground:
    """What does not move, seen from above [m].

    Attributes:
        hulls: (h, 2) each.
        marks: the landmarks.
        radius: of a landmark.
    """

    hulls: Sequence[FloatArray]
    marks: Sequence[TargetMark]
    radius: float


def from_above(motion_points: BodyPoints, ground: Ground, still: int, label: str) -> str:
    """Feet and CoP from above, x upwards, y to the left.

    Args:
        motion_points: of the motion.
        ground: below it.
        still: the frame that is drawn.
        label: time of that frame.
    """
    shown = [
        motion_points.points[:, list(part), :2].reshape(-1, 2)
        for part in (*motion_points.soles, (motion_points.cop,))
    ]
    shown += [mark.place[None] for mark in ground.marks]
    low, high = np.vstack(shown).min(axis=0), np.vstack(shown).max(axis=0)
    span = high - low
    scale = min((WIDTH - 24.0) / span[1], TALLEST / span[0])
    height = TOP_ABOVE + scale * span[0] + 24.0
    middle = WIDTH / 2.0 + scale * (low[1] + high[1]) / 2.0
    view = PlayerView((1, 0), (-scale, -scale), (middle, TOP_ABOVE + scale * high[0]))
    body = [sole(side, "o g", motion_points, view, still) for side in (0, 1)]
    body += [
        shape("area", one, motion_points, view, still, 'class="q"')
        for one in motion_points.polygons
    ]
    fixed = [f'<path d="{area(view.project(flat(hull)))}" class="h"/>' for hull in ground.hulls]
    way = motion_points.points[:, motion_points.cop]
    fixed.append(f'<path d="{line(view.project(way))}" class="w"/>')
    moving = [
        shape("trace", (motion_points.cop,), motion_points, view, still, 'class="t"'),
        shape("dot", (motion_points.cop,), motion_points, view, still, 'r="5" class="p"'),
    ]
    marks = _marks(view, ground, scale)
    group = f'<g data-view="{view.attribute}">'
    inner = (
        f'<text x="0" y="{HEADING:g}" class="s m">from above, the robot faces upwards</text>'
        f"{time_label(label)}{group}{''.join(body)}</g>{''.join(fixed)}{''.join(marks)}"
        f"{group}{''.join(moving)}</g>{scale_bar(WIDTH - 4.0, height - 3.0, scale)}"
        f'<circle cx="6" cy="{height - 7:g}" r="5" class="p"/>'
        f'<text x="15" y="{height - 4:g}" class="s m">CoP (the CoM’s ground projection)</text>'
    )
    return document(height, inner, f"Feet and planned CoP from above, {label}.")


def _marks(view: PlayerView, ground: Ground, scale: float) -> list[str]:
    """Rings of the landmarks, their numbers outwards of their middle."""
    if not ground.marks:
        return []
    places = view.project(flat(np.array([mark.place for mark in ground.marks])))
    drawn, radius = [], ground.radius * scale
    for mark, place in zip(ground.marks, places, strict=True):
        away = place - places.mean(axis=0)
        length = float(np.linalg.norm(away))
        outwards = away / length if length > 1.0 else np.array([0.0, -1.0])
        (x, y), (u, v) = (
            place,
            place + outwards * (radius + 6.0 + 3.0 * len(mark.numbers), radius + 9.0),
        )
        kind = " n" if mark.missing else ""
        drawn.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" class="l{kind}"/>'
            f'<text x="{u:.1f}" y="{v + 3.5:.1f}" class="i{kind}">{escape(mark.numbers)}</text>'
        )
    return drawn
