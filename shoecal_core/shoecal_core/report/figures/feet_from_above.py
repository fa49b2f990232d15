"""Feet and CoP of a motion from above, so that they can be animated."""

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
from shoecal_core.report.plan_content import TargetMark
from shoecal_core.report.player import PlayerView
from shoecal_core.report.svg import WIDTH

FloatArray = NDArray[np.float64]

TOP = 32.0
TALLEST = 300.0


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
    height = TOP + scale * span[0] + 24.0
    middle = WIDTH / 2.0 + scale * (low[1] + high[1]) / 2.0
    view = PlayerView((1, 0), (-scale, -scale), (middle, TOP + scale * high[0]))
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
