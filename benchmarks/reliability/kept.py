"""Finished steps of a row, in a file, so that a killed run continues."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path

from reliability.row import Progress, Result, Row, merge
from shoecal_core.errors import FileError
from shoecal_core.files import atomic_write


class Kept:
    """The finished steps of a row, one after the other from its first try."""

    def __init__(self, row: Row, folder: Path, seed: int, *, fresh: bool = False) -> None:
        """Read the finished steps.

        Args:
            row: the row.
            folder: of the rows' files.
            seed: from which the tries are drawn.
            fresh: start again; the next step replaces what the file holds.

        Raises:
            FileError: when the file cannot be read, or was made with another seed.
        """
        self._row, self._seed = row, seed
        self._path = folder / f"{row.key}.json"
        self._steps: list[Result] = []
        if fresh or not self._path.is_file():
            return
        try:
            content = json.loads(self._path.read_text())
            same_seed = content["seed"] == seed
            self._steps = [Result(**step) for step in content["steps"]]
        except (ValueError, KeyError, TypeError) as error:
            raise FileError(self._path, "is no file of results; remove it") from error
        if not same_seed:
            raise FileError(
                self._path,
                f"was made with seed {content['seed']}, not {seed}; --fresh starts again",
            )

    @property
    def result(self) -> Result:
        """Result of all finished tries."""
        return merge(self._steps)

    def next_step(self, share: float) -> tuple[int, int]:
        """First try and number of tries of the next step; 0 tries when the share is complete.

        Args:
            share: of all tries of the row, from 0 to 1.
        """
        first, wanted = self.result.tried, max(1, math.ceil(share * self._row.tries))
        return first, max(0, min(self._row.step - first % self._row.step, wanted - first))

    def run(self, first: int, count: int, progress: Progress) -> Result:
        """Run the next step and write it to the file.

        Raises:
            ValueError: when the row leaves tries out although none failed.
        """
        result = self._row.run(first, count, self._seed, progress)
        if not (result.tried == count or (0 < result.tried < count and result.failed)):
            raise ValueError(f"{self._row.key}: {result.tried} tries were run, not {count}")
        self._steps.append(result)
        content = {"seed": self._seed, "steps": [asdict(step) for step in self._steps]}
        self._path.parent.mkdir(parents=True, exist_ok=True)
        atomic_write(self._path, json.dumps(content, indent=1, allow_nan=False) + "\n")
        return result
