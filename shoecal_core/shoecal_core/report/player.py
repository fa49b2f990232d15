"""An animation within a page: a script draws shapes through points that move in time.

Python says where points are and which shapes go through them; all drawing is the script's.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray

SPEEDS = (1, 2, 4, 8)
USUAL_SPEED = 4

Shape = tuple[str, str, Sequence[int], float | str | None]
"""CSS class; kind; indices of points; what else the kind needs.

Kinds: `line` through pairs of points (width in mm or None: that of the class), `area` within
points (the foot of which it is the sole, `l` or `r`, or None), `way` of a point over the whole
motion, `trace` of it until now, `ring` about a point (radius in mm), `text` at a point (words).
"""


@dataclass(frozen=True)
class PlayerView:
    """A side from which the points are seen.

    Attributes:
        title: above it.
        right, down: axis (0, 1 or 2) and sign (1 or -1) of what is to the right and downwards.
        box: left, upper edge, width and height of what is shown [mm].
        shapes: the first is drawn first.
    """

    title: str
    right: tuple[int, int]
    down: tuple[int, int]
    box: tuple[float, float, float, float]
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Player:
    """An animation.

    Attributes:
        title, caption: above and below it.
        views: of it.
        points: see PlayerPoints.
        duration: of the motion [s].
        lifted: one letter a frame: the foot in the air, `l`, `r`, or `-` for none.
    """

    title: str
    views: tuple[PlayerView, ...]
    points: PlayerPoints
    duration: float
    lifted: str
    caption: str = ""

    @property
    def data(self) -> str:
        """JSON for the script."""
        views = [{"right": one.right, "down": one.down, "shapes": one.shapes} for one in self.views]
        rest = {"duration": self.duration, "lifted": self.lifted, "views": views}
        # A name that closes the script element must not be able to.
        return f'{{"points":{self.points.data},{_json(rest)[1:]}'.replace("<", "\\u003c")


class PlayerPoints:
    """Where points are in each frame; those that move alike are kept once.

    Args:
        frames: how many, at equal distances in time.
    """

    def __init__(self, frames: int) -> None:
        self._frames = frames
        self._tracks: dict[str, int] = {}

    def add(self, places: FloatArray, decimals: int = 0) -> list[int]:
        """Indices of points (F, k, 3), or (k, 3) that never move [m].

        Args:
            places: of the points.
            decimals: of millimetres that are kept.
        """
        moving = np.broadcast_to(places, (self._frames, *places.shape[-2:]))
        tracks = np.round(1e3 * moving, decimals).transpose(1, 2, 0).tolist()
        return [
            self._tracks.setdefault(_json([_track(axis) for axis in point]), len(self._tracks))
            for point in tracks
        ]

    @property
    def data(self) -> str:
        """JSON: of each point three lists over the frames [mm], a number where one is constant."""
        return f"[{','.join(self._tracks)}]"


def _track(values: list[float]) -> float | list[float]:
    numbers = [int(value) if value.is_integer() else value for value in values]
    return numbers[0] if len(set(numbers)) == 1 else numbers


def _json(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), allow_nan=False)
