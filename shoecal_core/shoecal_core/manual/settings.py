"""What a manual calibration is done with."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from shoecal_core.files import Fields, read_yaml
from shoecal_core.manual.loads import CELLS
from shoecal_core.manual.measurements import LARGEST_MASS

FORMAT = 1


@dataclass(frozen=True)
class ManualSettings:
    """As in `config/manual.yaml`.

    Attributes:
        shoe_weights, cell_weights: [kg], rising.
        samples: of one reading.
        still_fraction: largest standard deviation of a still reading, over the converter's range.
        patience: samples after which a reading that is not still is given up.
    """

    shoe_weights: tuple[float, ...]
    cell_weights: tuple[float, ...]
    samples: int
    still_fraction: float
    patience: int

    def weights(self, kind: str) -> tuple[float, ...]:
        """For single cells or for the shoe [kg]."""
        return self.cell_weights if kind == CELLS else self.shoe_weights


def load_manual_settings(path: Path) -> ManualSettings:
    """Read the settings.

    Raises:
        FileError: for anything missing, mistyped or out of bounds.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(
        "format", "shoe_weights_kg", "cell_weights_kg", "samples", "still_fraction",
        "patience_samples",
    )  # fmt: skip
    samples = fields.integer("samples", minimum=2)
    return ManualSettings(
        shoe_weights=_weights(fields, "shoe_weights_kg"),
        cell_weights=_weights(fields, "cell_weights_kg"),
        samples=samples,
        still_fraction=fields.number("still_fraction", above=0.0, maximum=1.0),
        patience=fields.integer("patience_samples", minimum=samples),
    )


def _weights(fields: Fields, key: str) -> tuple[float, ...]:
    weights = tuple(fields.array(key, (None,)).tolist())
    if not weights or list(weights) != sorted(set(weights)) or weights[0] <= 0.0:
        raise fields.error(key, "expected weights above 0 kg, each larger than the one before")
    if weights[-1] > LARGEST_MASS:
        raise fields.error(key, f"{weights[-1]:g} kg looks like grams; masses are in kg")
    return weights
