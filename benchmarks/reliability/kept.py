"""Results of one row, kept step by step, so that a run that was killed is taken up again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from reliability.row import Progress, Result, Row, merge
from shoecal_core.errors import FileError
from shoecal_core.files import atomic_write


@dataclass(frozen=True)
class Piece:
    """Tries done at once.

    Attributes:
        result: what came of them.
        code: digest of the sources that they ran with; empty: nobody knows.
    """

    result: Result
    code: str


class Kept:
    """Finished steps of a row: a file that is whole at any moment."""

    def __init__(self, row: Row, folder: Path, seed: int, code: str = "") -> None:
        """What the folder holds of the row.

        Args:
            row: it.
            folder: of the files.
            seed: that tries are drawn from.
            code: digest of the sources at hand.

        Raises:
            FileError: when the file cannot be read, or was made with another seed.
        """
        self._row, self._seed, self._code = row, seed, code
        self._path = folder / f"{row.key}.json"
        self._pieces: dict[int, Piece] = {}
        self._repeated: list[Piece] = []
        if not self._path.is_file():
            return
        try:
            held = json.loads(self._path.read_text())
            same_seed = held["seed"] == seed
            self._pieces = {int(first): _piece(piece) for first, piece in held["steps"].items()}
            self._repeated = [_piece(piece) for piece in held.get("repeated", ())]
        except (ValueError, KeyError, TypeError) as error:
            raise FileError(self._path, "is no file of results; remove it") from error
        if not same_seed:
            raise FileError(
                self._path,
                f"was made with seed {held['seed']}, not {seed}; remove it to begin anew",
            )

    @property
    def result(self) -> Result:
        """All that was tried so far."""
        return merge(piece.result for piece in self._pieces.values())

    @property
    def present(self) -> int:
        """Tries that ran with the code at hand."""
        return sum(
            piece.result.tried for piece in self._pieces.values() if piece.code == self._code
        )

    @property
    def before(self) -> Result:
        """Tries that had failed, and were then done once more with the same code; none: 0 tried."""
        return merge(piece.result for piece in self._repeated)

    def forget(self) -> None:
        """Begin anew; what has failed with the code at hand is not forgotten."""
        self._replace(self._pieces.values(), {})
        if self._repeated:
            self._write()
        else:
            self._path.unlink(missing_ok=True)

    def missing(self, share: float, *, earlier_counts: bool = False) -> Iterator[tuple[int, int]]:
        """First try and number of tries of each step that a share of the row still needs.

        Args:
            share: of all tries.
            earlier_counts: whether tries that ran with other code need not be done again.
        """
        tries = min(self._row.tries, max(1, math.ceil(share * self._row.tries)))
        for first in range(0, tries, self._row.step):
            begin, end = first, min(first + self._row.step, tries)
            for done, piece in sorted(self._pieces.items()):
                if piece.code != self._code and not earlier_counts:
                    continue
                if begin < (until := min(done, end)):
                    yield begin, until - begin
                begin = max(begin, done + piece.result.tried)
            if begin < end:
                yield begin, end - begin

    def run(self, first: int, count: int, progress: Progress) -> Result:
        """Do a step and keep it."""
        result = self._row.run(first, count, self._seed, progress)
        if not (result.tried == count or (result.tried < count and result.failed)):
            raise ValueError(f"{self._row.key}: {result.tried} tries were done, not {count}")
        end = first + result.tried
        others = {
            begin: piece
            for begin, piece in self._pieces.items()
            if begin >= end or begin + piece.result.tried <= first
        }
        replaced = [piece for begin, piece in self._pieces.items() if begin not in others]
        self._replace(replaced, {**others, first: Piece(result, self._code)})
        self._write()
        return result

    def _replace(self, replaced: Iterable[Piece], pieces: dict[int, Piece]) -> None:
        """Hold these pieces; those replaced that had failures with the same code are still told."""
        again = merge(piece.result for piece in replaced if piece.code == self._code)
        if again.failed:
            self._repeated.append(Piece(again, self._code))
        self._pieces = pieces
        codes = {self._code, *(piece.code for piece in pieces.values())}
        self._repeated = [piece for piece in self._repeated if piece.code in codes]

    def _write(self) -> None:
        held: dict[str, object] = {
            "seed": self._seed,
            "step": self._row.step,
            "steps": {str(begin): _plain(piece) for begin, piece in sorted(self._pieces.items())},
        }
        if self._repeated:
            held["repeated"] = [_plain(piece) for piece in self._repeated]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        atomic_write(self._path, json.dumps(held, indent=1, allow_nan=False) + "\n")


def _plain(piece: Piece) -> dict[str, Any]:
    return {**asdict(piece.result), "code": piece.code}


def _piece(held: dict[str, Any]) -> Piece:
    code = held.pop("code", "")
    return Piece(Result(**held), str(code))
