"""Errors run by run and by set."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set, errors_of
from shoecal_core.estimation.series import Series


def series(grf: float, count: int, cop: float = 0.0) -> Series:
    """GRF [N] and CoP x [m] off zero by the same everywhere."""
    place = np.zeros((count, 2))
    place[:, 0] = cop
    return Series(
        np.arange(count, dtype=np.float64),
        np.full(count, grf),
        place,
        np.zeros((count, 2)),
        np.zeros((count, 2, 2)),
    )


def run(
    number: int, grf: float, *, name: str = "test", count: int = 5, session: str = "a"
) -> ComparedRun:
    """One whose GRF is off by `grf` N and whose CoP by as many mm."""
    sources = {
        "measured": (series(grf, count, 1e-3 * grf),),
        "truth": (series(0.0, count),),
    }
    return ComparedRun(session, number, name, sources)


def test_samples_count_in_errors() -> None:
    runs = [run(1, 1.0, count=30), run(2, 4.0, count=10)]
    assert errors_of(runs, "measured", "truth").grf.mean == pytest.approx(1.75)
    assert errors_of(runs, "measured", "measured").cop.mean == 0.0


def test_stances_of_a_run_are_one_run() -> None:
    one, other = run(1, 1.0, count=6), run(1, 3.0, count=2)
    both = ComparedRun("a", 1, "test", {
        name: one.sources[name] + other.sources[name] for name in one.sources
    })  # fmt: skip
    assert errors_of([both], "measured", "truth").grf.mean == pytest.approx(1.5)


def test_by_set_and_without_one() -> None:
    sets = errors_by_set([run(1, 1.0), run(2, 3.0, name="train")], "measured", "truth")
    assert {name: found.grf.mean for name, found in sets.items()} == {"train": 3.0, "test": 1.0}
    assert set(errors_by_set([run(1, 1.0)], "measured", "truth")) == {"test"}
