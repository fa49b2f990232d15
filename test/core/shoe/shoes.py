"""The shoes that sensing, model and calibration are tested with."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from shoecal_core.shoe.shoe import (
    AXES,
    FEET,
    Channel,
    Plates,
    Shoe,
    axis_column,
    cell_column,
)
from shoecal_core.shoe.shoe_file import load_shoe

ROOT = Path(__file__).parents[3]
FILES = {
    "nao_shoe": ROOT / "config/shoes/nao_shoe.yaml",
    "wren_shoe": ROOT / "config/shoes/wren_shoe.yaml",
    "odd_shoe": ROOT / "test/data/shoes/odd_shoe.yaml",
}
NAMES = tuple(FILES)
NO_PLATES = Plates(0.0, np.zeros(3), 0.0, np.zeros(3))


@cache
def shoe(name: str) -> Shoe:
    """One of the shoes that come as files."""
    return load_shoe(FILES[name])


def made(channels: Sequence[Channel], plates: tuple[Plates, Plates] | None = None) -> Shoe:
    """A pair of shoes without a file; plates without mass where none are given."""
    return Shoe(
        name="made",
        unit="V",
        height=0.02,
        channels=tuple(channels),
        plates=(NO_PLATES, NO_PLATES) if plates is None else plates,
        path=Path("made.yaml"),
        digest="0" * 64,
    )


def cells(foot: int, positions: ArrayLike, polarity: int = 1) -> list[Channel]:
    """Load cells of one foot at positions (k, 2) [m]."""
    return [
        Channel(
            name=f"{FEET[foot]}/{index}",
            foot=foot,
            column=cell_column(position),
            position=position,
            torque=False,
            polarity=polarity,
            nominal_gain=None,
            lowest=-5.0,
            highest=5.0,
        )
        for index, position in enumerate(np.asarray(positions, dtype=np.float64))
    ]


def six_axis(
    foot: int, origin: ArrayLike, axes: Sequence[str] = AXES, gain: float | None = 1.0
) -> list[Channel]:
    """Axes of a six-axis sensor of one foot at `origin` (3,) [m]."""
    place = np.asarray(origin, dtype=np.float64)
    return [
        Channel(
            name=f"{FEET[foot]}/{axis}",
            foot=foot,
            column=axis_column(axis, place),
            position=place[:2],
            torque=axis.startswith("m"),
            polarity=1,
            nominal_gain=gain,
            lowest=-1e3,
            highest=1e3,
        )
        for axis in axes
    ]
