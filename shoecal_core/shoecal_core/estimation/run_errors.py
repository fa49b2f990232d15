"""Errors run by run, of one session or several, and by set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.estimation.series import Errors, Series, errors

SETS = ("train", "test")


@dataclass(frozen=True)
class ComparedRun:
    """All series of one run, at the same instants.

    Attributes:
        session: a name that no other session bears.
        run: its number there.
        set: `train` or `test`.
        sources: by name, one series a stance.
    """

    session: str
    run: int
    set: str
    sources: Mapping[str, tuple[Series, ...]]


def errors_of(runs: Sequence[ComparedRun], source: str, reference: str) -> Errors:
    """Errors over all samples of some runs."""
    return errors(
        [
            pair
            for run in runs
            for pair in zip(run.sources[source], run.sources[reference], strict=True)
        ]
    )


def errors_by_set(runs: Sequence[ComparedRun], source: str, reference: str) -> dict[str, Errors]:
    """The same by set; a set without runs is left out."""
    sets = {name: [run for run in runs if run.set == name] for name in SETS}
    return {name: errors_of(part, source, reference) for name, part in sets.items() if part}
