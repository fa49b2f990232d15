"""A number by which a robot that works may be off its files, and what it adds to the signals."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.arrays import FloatArray

FORM = 0.08
"""Part of what an effect adds that reality usually has in another form than the library."""


@dataclass(frozen=True)
class Deviation:
    """One number by which a robot that works may be off its files.

    Attributes:
        effect, location, component, unit: what it is, as in a diagnosis.
        std: as built, in its unit.
        column: (T, s) what one unit adds to measured minus modelled, in every signal.
        run: the run that it belongs to; None: all of them.
        form: part of it that a robot may have in another form than the column's.
        shoe_column: (n, 3) what one unit adds to the channels' columns in their own sole's frame,
            [m] for the moments of a force; None where the shoe's channels stay as they are.
    """

    effect: str
    location: tuple[str, ...]
    component: str
    unit: str
    std: float
    column: FloatArray
    run: int | None = None
    form: float = FORM
    shoe_column: FloatArray | None = None

    @property
    def key(self) -> tuple[str, tuple[str, ...], str, int | None]:
        """What it is known by."""
        return self.effect, self.location, self.component, self.run
