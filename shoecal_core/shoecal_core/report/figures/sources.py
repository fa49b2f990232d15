"""Where an expected error comes from: its largest sources by name."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.report.palette import INK, MUTED, RED
from shoecal_core.report.svg import SMALL, WIDTH, canvas, readable

ROW, BOTTOM = 24.0, 34.0


def largest_sources(names: Sequence[str], sizes: Sequence[float], unit: str, label: str) -> str:
    """One bar an error source, the largest first.

    Args:
        names: of the sources.
        sizes: of the error that each causes.
        unit: of the sizes.
        label: of the axis.
    """
    labels = [readable(name, 38) for name in names]
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
        return page.svg(f"Sources of the expected error: {listed}.")


def _sized(value: float, unit: str) -> str:
    return f"{value:.1f} {unit}" if value < 9.95 else f"{value:.0f} {unit}"
