"""Calibration files that were tampered with.

Mutants as of other YAML files. One is refused with one line that names the file, or loaded as it
says: what was loaded, written again and loaded once more is the same. A digit that was altered into
another one is a calibration like any other to `shoecal`; the calibrator knows by its record of
hashes which file it put in force itself.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.loading import WrongLoadError, make_trap, try_mutants
from reliability.row import Row
from reliability.same import same
from reliability.tree_mutations import mutate_yaml
from shoecal_core.calibration.calibration import load_calibration, save_calibration
from shoecal_core.errors import FileError


def target(folder: Path) -> CalibrationFile:
    """One calibration."""
    return CalibrationFile(folder)


class CalibrationFile:
    """A calibration, a mutant soon."""

    codes = frozenset({"file-syntax", "file-too-large", "field", "version", "calibration-file"})

    def __init__(self, folder: Path) -> None:
        make_trap(folder)
        self._folder, self._path = folder, folder / "calibration.yaml"
        self._again = folder / "again.yaml"
        save_calibration(originals.calibration(), self._path)
        self._whole = self._path.read_bytes()
        self._good = load_calibration(self._path)

    def mutate(self, rng: np.random.Generator) -> str:
        what, mutant = mutate_yaml(self._whole, rng, self._folder)
        self._path.write_bytes(mutant)
        return what

    def load(self) -> None:
        loaded = load_calibration(self._path)
        numbers = (loaded.parameters.gain, loaded.parameters.offset, np.array(loaded.weight))
        if not all(np.isfinite(one).all() for one in numbers):
            raise WrongLoadError("a number that is not finite")
        save_calibration(loaded, self._again)
        try:
            again = load_calibration(self._again)
        except FileError as error:
            raise WrongLoadError(f"written again it is refused: {error}") from error
        if not same(loaded, again):
            raise WrongLoadError("written again it is another")


ROW = Row(
    key="mutants-calibration",
    fault="mutated calibration",
    holds="refused with one line that names the file, or loaded as it says; at most 2 GiB and "
    "10 s of the processor; nothing of it runs",
    tries=10_000,
    step=500,
    run=partial(try_mutants, "mutated_calibrations"),
)
