"""Where an expected error comes from: shares of its square, and the largest causes by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.patches import Patch

from shoecal_core.report.palette import BLUE, INK, MUTED, RED, TEAL, Colour
from shoecal_core.report.svg import SMALL, WIDTH, canvas, readable

ROW, TOP, BOTTOM, NUMBERS = 24.0, 24.0, 34.0, 62.0
PART_COLOURS: tuple[Colour, ...] = (TEAL, BLUE, RED)


@dataclass(frozen=True)
class Whole:
    """One error and its independent parts.

    Attributes:
        label: of it.
        parts: sizes of its parts; their squares add up.
    """

    label: str
    parts: tuple[float, ...]

    @property
    def size(self) -> float:
        """Root of the sum of squares."""
        return float(np.hypot.reduce(self.parts))


def shares(names: Sequence[str], wholes: Sequence[Whole], unit: str) -> str:
    """One full bar an error, divided by its parts' squares; its size at the end."""
    left = 14.0 + 5.6 * max(len(one.label) for one in wholes)
    height = ROW * len(wholes)
    with canvas(TOP + height + BOTTOM) as page:
        page.legend(
            [
                Patch(facecolor=colour.light, edgecolor="none", label=readable(name))
                for name, colour in zip(names, PART_COLOURS, strict=False)
            ]
        )
        axes = page.panel(TOP, height, left=left, right=WIDTH - NUMBERS)
        axes.grid(visible=False, axis="y")
        for row, one in enumerate(wholes):
            start = 0.0
            for part, colour in zip(one.parts, PART_COLOURS, strict=False):
                share = 100.0 * part**2 / one.size**2 if one.size > 0.0 else 0.0
                axes.barh(row, share, 0.56, left=start, color=colour.light, edgecolor="none")
                start += share
            axes.annotate(_sized(one.size, unit), (100.0, row), (6.0, 0.0),
                          textcoords="offset points", va="center", fontsize=SMALL,
                          annotation_clip=False)  # fmt: skip
        axes.set_xlim(0.0, 100.0)
        axes.set_ylim(len(wholes) - 0.45, -0.55)
        axes.set_yticks(range(len(wholes)), [readable(one.label) for one in wholes])
        axes.tick_params(axis="y", length=0.0, labelcolor=INK.light)
        axes.set_xlabel("share of the mean square (%)")
        told = "; ".join(
            f"{one.label} {_sized(one.size, unit)}: "
            + ", ".join(
                f"{name} {_sized(part, unit)}" for name, part in zip(names, one.parts, strict=True)
            )
            for one in wholes
        )
        return page.svg(f"Where expected errors come from. {told}.")


def largest_causes(names: Sequence[str], sizes: Sequence[float], unit: str, label: str) -> str:
    """One bar a cause, the largest first.

    Args:
        names: of the causes.
        sizes: of what they add.
        unit: of the sizes.
        label: of the axis.
    """
    labels = [readable(name, 34) for name in names]
    left = 14.0 + 5.3 * max(map(len, labels))
    height = ROW * 0.85 * len(names)
    with canvas(4.0 + height + BOTTOM) as page:
        axes = page.panel(4.0, height, left=left, right=WIDTH - 44.0)
        axes.grid(visible=False, axis="y")
        axes.barh(range(len(names)), sizes, 0.56, color=RED.light, edgecolor="none")
        for row, size in enumerate(sizes):
            axes.annotate(_sized(size, unit), (size, row), (4.0, 0.0), textcoords="offset points",
                          va="center", fontsize=SMALL, color=MUTED.light,
                          annotation_clip=False)  # fmt: skip
        axes.set_xlim(0.0, max(*sizes, 1e-9))
        axes.set_ylim(len(names) - 0.45, -0.55)
        axes.set_yticks(range(len(names)), labels)
        axes.tick_params(axis="y", length=0.0, labelcolor=INK.light)
        axes.locator_params(axis="x", nbins=4)
        axes.set_xlabel(f"{label} ({unit})")
        listed = ", ".join(
            f"{name} {_sized(size, unit)}" for name, size in zip(labels, sizes, strict=True)
        )
        return page.svg(f"Largest causes of expected errors: {listed}.")


def _sized(value: float, unit: str) -> str:
    return f"{value:.1f} {unit}" if value < 9.95 else f"{value:.0f} {unit}"
