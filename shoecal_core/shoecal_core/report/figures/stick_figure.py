"""A motion as stick figures that can be animated: from the right, from the front, from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.motion import BODY, LEFT_SIDE, RIGHT_SIDE, SIDES, Skeleton
from shoecal_core.report.palette import Colour
from shoecal_core.report.plan_targets import Mark
from shoecal_core.report.player import View
from shoecal_core.report.svg import WIDTH

FloatArray = NDArray[np.float64]

TOP, FLOOR, GAP = 40.0, 14.0, 12.0
TALLEST = 300.0
FEET = ("l", "r")


@dataclass(frozen=True)
class Cast:
    """The points of a motion, and which of them make which part of the body.

    Attributes:
        points: (F, P, 3) in the world, z up [m].
        bones: by LEFT_SIDE, RIGHT_SIDE and BODY: indices of ends, two a bone.
        capsules: indices of ends, and radius [m].
        soles, polygons: corners of left and right sole and sensing polygon.
        com, cop: their points; the CoP is on the floor.
    """

    points: FloatArray
    bones: tuple[tuple[int, ...], ...]
    capsules: tuple[tuple[int, int, float], ...]
    soles: tuple[tuple[int, ...], tuple[int, ...]]
    polygons: tuple[tuple[int, ...], tuple[int, ...]]
    com: int
    cop: int


def cast_of(
    skeletons: Sequence[Skeleton],
    polygons: Sequence[tuple[FloatArray, FloatArray]],
    radii: Sequence[float],
) -> Cast:
    """Gather points of all instants, each distinct one once.

    Args:
        skeletons: (F) in the world.
        polygons: (F) corners (k, 3) of left and right sensing polygon in the world [m].
        radii: of the capsules [m].
    """
    rows = [
        np.vstack(
            (
                body.bones.reshape(-1, 3), body.capsules.reshape(-1, 3), *body.soles, *corners,
                body.com[None], [[*body.com[:2], 0.0]],
            )
        )
        for body, corners in zip(skeletons, polygons, strict=True)
    ]  # fmt: skip
    points = np.stack(rows)
    # Points that move as one within a tenth of a millimetre are drawn as one.
    keys = np.round(1e4 * points.transpose(1, 0, 2).reshape(points.shape[1], -1))
    _, kept, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    place = index.ravel()
    first, counts = skeletons[0], iter(range(len(place)))

    def take(count: int) -> tuple[int, ...]:
        return tuple(int(place[next(counts)]) for _ in range(count))

    ends = np.array(take(2 * len(first.bones))).reshape(-1, 2)
    moving = [bone for bone in range(len(ends)) if ends[bone, 0] != ends[bone, 1]]
    capsules = np.array(take(2 * len(radii)), dtype=int).reshape(-1, 2)
    soles = (take(len(first.soles[0])), take(len(first.soles[1])))
    sensing = (take(len(polygons[0][0])), take(len(polygons[0][1])))
    (com,), (cop,) = take(1), take(1)
    return Cast(
        points=points[:, kept],
        bones=tuple(
            tuple(int(end) for bone in moving if first.side[bone] == side for end in ends[bone])
            for side in (LEFT_SIDE, RIGHT_SIDE, BODY)
        ),
        capsules=tuple(
            (int(a), int(b), radius) for (a, b), radius in zip(capsules, radii, strict=True)
        ),
        soles=soles,
        polygons=sensing,
        com=com,
        cop=cop,
    )


def from_the_side(cast: Cast, still: int, label: str) -> str:
    """The whole body from its right, and from its front, at one frame.

    Args:
        cast: of the motion.
        still: the frame that is drawn.
        label: time of that frame.
    """
    low, high = _extent(cast)
    span, width = high - low, (WIDTH - GAP) / 2.0
    scale = min((width - 8.0) / max(span[0], span[1]), TALLEST / span[2])
    floor = TOP + scale * high[2]
    height = floor + FLOOR - scale * low[2]
    parts = []
    for panel, (across, name) in enumerate(((0, "from the right"), (1, "from the front"))):
        left = panel * (width + GAP)
        middle = left + width / 2.0 - scale * (low[across] + high[across]) / 2.0
        view = View((across, 2), (scale, -scale), (middle, floor))
        parts.append(
            f'<text x="{left:g}" y="{TOP - 8:g}" class="s m">{name}</text>'
            f'<path d="M{left:g} {floor:g}H{left + width:g}" class="f"/>'
            f'<g data-view="{view.attribute}">{_body(cast, view, still, scale)}</g>'
        )
    parts.append(_scale_bar(WIDTH - 4.0, height - 3.0, scale))
    alt = f"Stick figure of the robot from its right and from its front, {label}."
    return _svg(height, _keys(label) + "".join(parts), alt)


def _extent(cast: Cast) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y, z) of all that is drawn, the floor included."""
    points = cast.points.reshape(-1, 3)
    low, high = np.append(points, [[np.inf, np.inf, 0.0]], axis=0).min(axis=0), points.max(axis=0)
    for start, end, radius in cast.capsules:
        ends = cast.points[:, [start, end]].reshape(-1, 3)
        low[:2] = np.minimum(low, ends.min(axis=0) - radius)[:2]
        high = np.maximum(high, ends.max(axis=0) + radius)
    return low, high


def _body(cast: Cast, view: View, frame: int, scale: float) -> str:
    drawn = []
    for a, b, radius in cast.capsules:
        drawn.append(_shape("bones", (a, b), cast, view, frame,
                            f'class="c" stroke-width="{2 * radius * scale:.1f}"'))  # fmt: skip
    for side, sole in enumerate(cast.soles):
        style = f'data-foot="{FEET[side]}" class="o" style="{_paint(SIDES[side])}"'
        drawn.append(_shape("area", sole, cast, view, frame, style))
    for side in (BODY, RIGHT_SIDE, LEFT_SIDE):
        style = f'class="b" style="stroke:var(--{SIDES[side].name})"'
        drawn.append(_shape("bones", cast.bones[side], cast, view, frame, style))
    drawn.append(_shape("bones", (cast.com, cast.cop), cast, view, frame, 'class="d"'))
    drawn.append(_shape("dot", (cast.com,), cast, view, frame, 'r="4" class="k"'))
    drawn.append(_shape("dot", (cast.cop,), cast, view, frame, 'r="3.5" class="p"'))
    return "".join(drawn)


@dataclass(frozen=True)
class Ground:
    """What does not move, seen from above [m].

    Attributes:
        hulls: (h, 2) each.
        marks: the landmarks.
        radius: of a landmark.
    """

    hulls: Sequence[FloatArray]
    marks: Sequence[Mark]
    radius: float


def from_above(cast: Cast, ground: Ground, still: int, label: str) -> str:
    """Feet and CoP from above, x upwards, y to the left.

    Args:
        cast: of the motion.
        ground: below it.
        still: the frame that is drawn.
        label: time of that frame.
    """
    shown = [cast.points[:, list(part), :2].reshape(-1, 2) for part in (*cast.soles, (cast.cop,))]
    shown += [mark.place[None] for mark in ground.marks]
    low, high = np.vstack(shown).min(axis=0), np.vstack(shown).max(axis=0)
    span = high - low
    scale = min((WIDTH - 24.0) / span[1], TALLEST / span[0])
    top = TOP - 8.0
    height = top + scale * span[0] + 24.0
    middle = WIDTH / 2.0 + scale * (low[1] + high[1]) / 2.0
    view = View((1, 0), (-scale, -scale), (middle, top + scale * high[0]))
    body = [
        _shape("area", sole, cast, view, still, f'data-foot="{FEET[side]}" class="o g"')
        for side, sole in enumerate(cast.soles)
    ]
    body += [_shape("area", one, cast, view, still, 'class="q"') for one in cast.polygons]
    fixed = [f'<path d="{_area(view.project(_flat(hull)))}" class="h"/>' for hull in ground.hulls]
    way = cast.points[:, cast.cop]
    fixed.append(f'<path d="{_line(view.project(way))}" class="w"/>')
    moving = [
        _shape("trace", (cast.cop,), cast, view, still, 'class="t"'),
        _shape("dot", (cast.cop,), cast, view, still, 'r="5" class="p"'),
    ]
    marks = _marks(view, ground, scale)
    group = f'<g data-view="{view.attribute}">'
    inner = (
        f'<text x="0" y="{TOP - 30:g}" class="s m">from above, the robot faces upwards</text>'
        f"{_time(label)}{group}{''.join(body)}</g>{''.join(fixed)}{''.join(marks)}"
        f"{group}{''.join(moving)}</g>{_scale_bar(WIDTH - 4.0, height - 3.0, scale)}"
        f'<circle cx="6" cy="{height - 7:g}" r="5" class="p"/>'
        f'<text x="15" y="{height - 4:g}" class="s m">CoP (the CoM’s ground projection)</text>'
    )
    return _svg(height, inner, f"Feet and planned CoP from above, {label}.")


def _marks(view: View, ground: Ground, scale: float) -> list[str]:
    """Rings of the landmarks, their numbers outwards of their middle."""
    if not ground.marks:
        return []
    places = view.project(_flat(np.array([mark.place for mark in ground.marks])))
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


def _shape(kind: str, points: Sequence[int], cast: Cast, view: View, frame: int, style: str) -> str:
    """An element that the script can move, as it is at one frame."""
    through = f'data-kind="{kind}" data-through="{" ".join(map(str, points))}"'
    seen = view.project(cast.points[frame, list(points)])
    if kind == "dot":
        x, y = seen[0]
        return f'<circle {through} {style} cx="{x:.1f}" cy="{y:.1f}"/>'
    if kind == "trace":
        drawn = _line(view.project(cast.points[: frame + 1, points[0]]))
    elif kind == "area":
        drawn = _area(seen)
    else:
        drawn = "".join(
            f"{'L' if index % 2 else 'M'}{x:.1f} {y:.1f}" for index, (x, y) in enumerate(seen)
        )
    return f'<path {through} {style} d="{drawn}"/>'


def _line(points: FloatArray) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _area(points: FloatArray) -> str:
    return f"{_line(points)}Z"


def _flat(points: FloatArray) -> FloatArray:
    return np.column_stack((points, np.zeros(len(points))))


def _paint(colour: Colour) -> str:
    return f"stroke:var(--{colour.name});fill:var(--{colour.name})"


def _time(label: str) -> str:
    return f'<text data-time="" x="{WIDTH - 4:g}" y="{TOP - 30:g}" class="e">{escape(label)}</text>'


def _keys(label: str) -> str:
    names = [(SIDES[0].name, "left leg"), (SIDES[1].name, "right leg"), (SIDES[2].name, "body")]
    drawn, x, y = [], 0.0, TOP - 30.0
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
    return "".join(drawn) + _time(label)


def _scale_bar(right: float, bottom: float, scale: float) -> str:
    """A round length that takes about a sixth of the figure."""
    lengths = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    length = max((one for one in lengths if one * scale < WIDTH / 5.0), default=lengths[0])
    return (
        f'<path d="M{right:g} {bottom - 4:g}v4h{-length * scale:.1f}v-4" class="r"/>'
        f'<text x="{right - length * scale - 5:.1f}" y="{bottom:g}" class="s m e">'
        f"{1e3 * length:g} mm</text>"
    )


def _svg(height: float, inner: str, alt: str) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:.0f}" role="img" aria-label={quoteattr(alt)}>'
        f"{inner}</svg>"
    )
