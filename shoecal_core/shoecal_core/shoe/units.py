"""Units that readings come in, by how many newtons or newton metres one of them is."""

from __future__ import annotations

from collections.abc import Mapping

FORCES = {
    9.80665: "kgf or kg", 4.44822: "lbf or lb", 0.00980665: "gf or g", 1000.0: "kN", 0.001: "mN",
}  # fmt: skip
MOMENTS = {
    0.001: "N mm", 0.01: "N cm", 9.80665: "kgf m", 0.0980665: "kgf cm",
    1000.0: "kN m",
}  # fmt: skip


def named_unit(ratio: float, units: Mapping[float, str], share: float) -> tuple[float, str] | None:
    """The nearest of some units, by the ratio of a gain to its data sheet's; None where none is as
    near as a share of it.
    """
    size, name = min(units.items(), key=lambda one: abs(ratio / one[0] - 1.0))
    return (size, name) if abs(ratio / size - 1.0) < share else None
