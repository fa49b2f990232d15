"""Errors run by run, of one session or several: by set, and training against test runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.evaluate import Errors, Series, errors
from shoecal_core.calibration.significance import Difference, compare_sets

FloatArray = NDArray[np.float64]

SETS = ("train", "test")
COMPARED = {"grf": (1.0, "n"), "cop": (1e3, "mm")}
"""What training and test runs are compared in: scale and unit in result files."""


@dataclass(frozen=True)
class ComparedRun:
    """All that is told of one run, at the same instants.

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


def train_against_test(
    runs: Sequence[ComparedRun], source: str, reference: str, generator: np.random.Generator
) -> dict[str, Difference]:
    """How the MAEs of test runs differ from those of training runs, by name in `COMPARED`.

    A run counts once, by its MAE [N, m], and is compared within its session only.
    """
    found = {}
    for name in COMPARED:
        strata: dict[str, dict[str, list[float]]] = {}
        for run in runs:
            mae = errors_of([run], source, reference).figures()[name][0]
            if mae.count:
                sets = strata.setdefault(run.session, {name: [] for name in SETS})
                sets[run.set].append(mae.mean)
        difference = compare_sets(
            [(np.array(sets["train"]), np.array(sets["test"])) for sets in strata.values()],
            generator,
        )
        if difference is not None:
            found[name] = difference
    return found


def differences_to_json(found: Mapping[str, Difference]) -> dict[str, object]:
    """Figures by their names in result files [N, mm]; an unbounded end of an interval is null."""
    return {
        name: {
            f"difference_{unit}": scale * one.value,
            f"ci95_{unit}": [scale * end if math.isfinite(end) else None for end in one.interval],
            "p_value": one.p_value,
            "smallest_p_value": one.smallest_p,
            "splits": one.splits,
            "exact": one.exact,
            "sessions": one.sessions,
            "train_runs": one.first,
            "test_runs": one.second,
        }
        for name, (scale, unit) in COMPARED.items()
        if (one := found.get(name)) is not None
    }
