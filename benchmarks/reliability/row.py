"""One fault that is tried very often, and the result.

A module of this package declares it as `ROW`, or several as `ROWS`; `faults.py` finds them. The
module's docstring says what is done, what must hold and what of it is simulated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

Progress = Callable[[int], None]
"""Called now and then with the number of finished tries of this step."""


@dataclass(frozen=True)
class Result:
    """Result of some tries.

    Attributes:
        tried: number of tries.
        failed: number of those that failed.
        worst: the worst try in a few words, with its figure, for example "1.4 s until back".
        figure: orders results: larger is worse. One that failed is worse than one that did not.
        counts: events counted in all tries, for example {"times the old one": 61}.
    """

    tried: int
    failed: int
    worst: str
    figure: float = 0.0
    counts: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that no more failed than were tried."""
        if not 0 <= self.failed <= self.tried:
            raise ValueError(f"{self.failed} of {self.tried} tries cannot fail")

    @property
    def text(self) -> str:
        """The worst try and the counts."""
        counted = ", ".join(f"{count:,} {what}" for what, count in self.counts.items())
        return "; ".join(filter(None, (self.worst, counted)))


Run = Callable[[int, int, int, Progress], Result]
"""`run(first, count, seed, progress)` does the tries `first` to `first + count - 1`, each drawn
from (seed, index) alone."""


@dataclass(frozen=True)
class Row:
    """A fault that is tried.

    A run that cannot go on after a failed try returns fewer tries than it was asked for, the failed
    one last; the next call does the others.

    Attributes:
        key: short name, also of its file of results.
        fault: what is done, for the page.
        holds: what must hold, for the table.
        tries: at full size.
        step: tries that are run and kept at once; a killed run loses no more.
        run: does some of the tries.
    """

    key: str
    fault: str
    holds: str
    tries: int
    step: int
    run: Run

    def __post_init__(self) -> None:
        """Check the sizes."""
        if self.tries < 1 or self.step < 1:
            raise ValueError(f"{self.key}: tries and step are at least 1")


def merge(results: Iterable[Result]) -> Result:
    """Results of all tries as one: the worst try, and the counts that all of them have."""
    every = list(results)
    if not every:
        return Result(0, 0, "not tried")
    worst = max(every, key=lambda result: (result.failed > 0, result.figure))
    counted = [what for what in worst.counts if all(what in result.counts for result in every)]
    return Result(
        sum(result.tried for result in every),
        sum(result.failed for result in every),
        worst.worst,
        worst.figure,
        {what: sum(result.counts[what] for result in every) for what in counted},
    )
