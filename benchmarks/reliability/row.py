"""One fault that is tried very often, and what came of it.

A module of this package that has a `ROW` is found by `faults.py`. Its docstring says in plain words
what is done, what must hold and what of it is simulated: it goes onto the page,
docs/evidence/reliability.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

Progress = Callable[[int], None]
"""Is told now and then how many tries of this step are done."""


@dataclass(frozen=True)
class Result:
    """What came of some tries.

    Attributes:
        tried: how many there were.
        failed: of them.
        worst: the worst try in a few words, with its figure, for example "1.4 s until back".
        figure: by which the worst of several results is known: larger is worse. Of results that
            failed and others, one that failed is the worst.
        counts: what was counted in all of the tries, by its words, for example
            {"times the old one": 61}.
    """

    tried: int
    failed: int
    worst: str
    figure: float = 0.0
    counts: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """No more can fail than was tried."""
        if not 0 <= self.failed <= self.tried:
            raise ValueError(f"{self.failed} of {self.tried} tries cannot fail")

    @property
    def told(self) -> str:
        """The worst, and what was counted, in words."""
        counted = ", ".join(f"{count:,} {what}" for what, count in self.counts.items())
        return "; ".join(filter(None, (self.worst, counted)))


Run = Callable[[int, int, int, Progress], Result]
"""Of `first, count, seed, progress`: does the tries `first` to `first + count - 1`, each drawn from
(seed, index) alone."""


@dataclass(frozen=True)
class Row:
    """A fault that is tried.

    A run that cannot go on where one try has failed gives fewer tries than it was asked for, with
    that one the last; the others are done by the next call.

    Attributes:
        key: short name, of its file of results too.
        fault: what is done, for the table.
        holds: what must hold, for the table.
        tries: at full size.
        step: tries that are done, and kept, at once; a killed run loses no more.
        run: does some of the tries.
    """

    key: str
    fault: str
    holds: str
    tries: int
    step: int
    run: Run

    def __post_init__(self) -> None:
        """Sizes are positive."""
        if self.tries < 1 or self.step < 1:
            raise ValueError(f"{self.key}: tries and step are at least 1")


def merge(results: Iterable[Result]) -> Result:
    """All tries together, with the worst of all, and what was counted in all of them."""
    all_of = list(results)
    if not all_of:
        return Result(0, 0, "not tried")
    worst = max(all_of, key=lambda result: (result.failed > 0, result.figure))
    # What only some have counted is no sum of all.
    counted = [what for what in worst.counts if all(what in result.counts for result in all_of)]
    return Result(
        sum(result.tried for result in all_of),
        sum(result.failed for result in all_of),
        worst.worst,
        worst.figure,
        {what: sum(result.counts[what] for result in all_of) for what in counted},
    )
