"""The points of a moving body, and SVG shapes through them that a page's script can move."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.motion import BODY, LEFT_SIDE, RIGHT_SIDE, Skeleton
from shoecal_core.report.player import PlayerView
from shoecal_core.report.svg import WIDTH

FloatArray = NDArray[np.float64]

FEET = ("l", "r")
"""As frames name the foot in the air."""
HEADING = 10.0
"""Units from the upper edge to the line of keys and time."""


@dataclass(frozen=True)
class BodyPoints:
    """The points of a motion, and which of them make which part of the body.

    Attributes:
        points: (F, P, 3) in the world, z up [m].
        bones: by LEFT_SIDE, RIGHT_SIDE and BODY: indices of ends, two a bone.
        capsules: indices of ends, and radius [m].
        soles, polygons: corners of left and right sole and sensing polygon.
        com, cop: their points; the CoP is on the floor.
        lifted: one letter a frame: the foot in the air, one of FEET, or `-` for none.
    """

    points: FloatArray
    bones: tuple[tuple[int, ...], ...]
    capsules: tuple[tuple[int, int, float], ...]
    soles: tuple[tuple[int, ...], tuple[int, ...]]
    polygons: tuple[tuple[int, ...], tuple[int, ...]]
    com: int
    cop: int
    lifted: str


def body_points(
    skeletons: Sequence[Skeleton],
    polygons: Sequence[tuple[FloatArray, FloatArray]],
    radii: Sequence[float],
    lifted: str,
) -> BodyPoints:
    """Gather points of all instants, each distinct one once.

    Args:
        skeletons: (F) in the world.
        polygons: (F) corners (k, 3) of left and right sensing polygon in the world [m].
        radii: of the capsules [m].
        lifted: as in Cast.
    """
    points, place = _distinct(
        [
            np.vstack(
                (
                    body.bones.reshape(-1, 3), body.capsules.reshape(-1, 3), *body.soles, *corners,
                    body.com[None], [[*body.com[:2], 0.0]],
                )
            )
            for body, corners in zip(skeletons, polygons, strict=True)
        ]
    )  # fmt: skip
    first, rest = skeletons[0], iter(place)

    def take(count: int) -> tuple[int, ...]:
        return tuple(itertools.islice(rest, count))

    ends = np.array(take(2 * len(first.bones))).reshape(-1, 2)
    # Joints that meet in one point leave no bone between them.
    long = ends[:, 0] != ends[:, 1]
    return BodyPoints(
        points=points,
        bones=tuple(
            tuple(ends[long & (first.side == side)].ravel().tolist())
            for side in (LEFT_SIDE, RIGHT_SIDE, BODY)
        ),
        capsules=tuple((next(rest), next(rest), radius) for radius in radii),
        soles=(take(len(first.soles[0])), take(len(first.soles[1]))),
        polygons=(take(len(polygons[0][0])), take(len(polygons[0][1]))),
        com=next(rest),
        cop=next(rest),
        lifted=lifted,
    )


def _distinct(frames: Sequence[FloatArray]) -> tuple[FloatArray, list[int]]:
    """Points (F, P, 3) of which none moves like another, and where each given one is among them."""
    points = np.stack(frames)
    # A tenth of a millimetre cannot be seen.
    keys = np.round(1e4 * points.transpose(1, 0, 2).reshape(points.shape[1], -1))
    _, kept, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return points[:, kept], place.ravel().tolist()


def shape(
    kind: str,
    points: Sequence[int],
    motion_points: BodyPoints,
    view: PlayerView,
    frame: int,
    style: str,
) -> str:
    """An element that the script can move, as it is at one frame."""
    through = f'data-kind="{kind}" data-through="{" ".join(map(str, points))}"'
    seen = view.project(motion_points.points[frame, list(points)])
    if kind == "dot":
        x, y = seen[0]
        return f'<circle {through} {style} cx="{x:.1f}" cy="{y:.1f}"/>'
    if kind == "trace":
        drawn = line(view.project(motion_points.points[: frame + 1, points[0]]))
    elif kind == "area":
        drawn = area(seen)
    else:
        drawn = "".join(
            f"{'L' if index % 2 else 'M'}{x:.1f} {y:.1f}" for index, (x, y) in enumerate(seen)
        )
    return f'<path {through} {style} d="{drawn}"/>'


def sole(
    side: int, look: str, motion_points: BodyPoints, view: PlayerView, frame: int, style: str = ""
) -> str:
    """Outline of one foot, which the script marks while it is in the air."""
    lifted = " lifted" if motion_points.lifted[frame] == FEET[side] else ""
    attributes = f'data-foot="{FEET[side]}" class="{look}{lifted}"{style}'
    return shape("area", motion_points.soles[side], motion_points, view, frame, attributes)


def line(points: FloatArray) -> str:
    """Path through points (n, 2) in units."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def area(points: FloatArray) -> str:
    """Closed path through points (n, 2) in units."""
    return f"{line(points)}Z"


def flat(points: FloatArray) -> FloatArray:
    """Points (n, 2) as points (n, 3) on the floor [m]."""
    return np.column_stack((points, np.zeros(len(points))))


def time_label(label: str) -> str:
    """What the script writes the time into."""
    return f'<text data-time="" x="{WIDTH - 4:g}" y="{HEADING:g}" class="e">{escape(label)}</text>'


def scale_bar(right: float, bottom: float, scale: float) -> str:
    """A round length that takes about a sixth of the figure."""
    lengths = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    length = max((one for one in lengths if one * scale < WIDTH / 5.0), default=lengths[0])
    return (
        f'<path d="M{right:g} {bottom - 4:g}v4h{-length * scale:.1f}v-4" class="r"/>'
        f'<text x="{right - length * scale - 5:.1f}" y="{bottom:g}" class="s m e">'
        f"{1e3 * length:g} mm</text>"
    )


def document(height: float, inner: str, alt: str) -> str:
    """An `<svg>` element of the reports' width."""
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:.0f}" role="img" aria-label={quoteattr(alt)}>'
        f"{inner}</svg>"
    )
