"""Results of one row, kept step by step, so that a run that was killed is taken up again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from reliability.row import Progress, Result, Row, merge
from shoecal_core.errors import FileError
from shoecal_core.files import atomic_write


class Kept:
    """Finished steps of a row: a file that is whole at any moment."""

    def __init__(self, row: Row, folder: Path, seed: int) -> None:
        """What the folder holds of the row.

        Raises:
            FileError: when the file cannot be read, or was made with another seed.
        """
        self._row, self._seed = row, seed
        self._path = folder / f"{row.key}.json"
        self._steps: dict[int, Result] = {}
        if not self._path.is_file():
            return
        try:
            held = json.loads(self._path.read_text())
            same_seed, same_step = held["seed"] == seed, held["step"] == row.step
            steps = {int(first): Result(**step) for first, step in held["steps"].items()}
        except (ValueError, KeyError, TypeError) as error:
            raise FileError(self._path, "is no file of results; remove it") from error
        if not same_seed:
            raise FileError(
                self._path, f"was made with seed {held['seed']}, not {seed}; begin with --fresh"
            )
        if same_step:
            self._steps = steps

    @property
    def result(self) -> Result:
        """All that was tried so far."""
        return merge(self._steps.values())

    def forget(self) -> None:
        """Begin anew."""
        self._steps = {}
        self._path.unlink(missing_ok=True)

    def missing(self, share: float) -> Iterator[tuple[int, int]]:
        """First try and number of tries of each step that a share of the row still needs."""
        tries = min(self._row.tries, max(1, math.ceil(share * self._row.tries)))
        for first in range(0, tries, self._row.step):
            count = min(self._row.step, tries - first)
            if first not in self._steps or self._steps[first].tried < count:
                yield first, count

    def run(self, first: int, count: int, progress: Progress) -> Result:
        """Do a step and keep it."""
        result = self._row.run(first, count, self._seed, progress)
        if result.tried != count:
            raise ValueError(f"{self._row.key}: {result.tried} tries were done, not {count}")
        self._steps[first] = result
        held = {
            "seed": self._seed,
            "step": self._row.step,
            "steps": {str(begin): asdict(self._steps[begin]) for begin in sorted(self._steps)},
        }
        self._path.parent.mkdir(parents=True, exist_ok=True)
        atomic_write(self._path, json.dumps(held, indent=1, allow_nan=False) + "\n")
        return result
