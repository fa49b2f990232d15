"""Errors run by run and by set, and train against test with the run as the unit."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from shoecal_core.calibration.evaluate import Series
from shoecal_core.calibration.run_errors import (
    ComparedRun,
    differences_to_json,
    errors_by_set,
    errors_of,
    train_against_test,
)

FloatArray = NDArray[np.float64]


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


def difference(runs: list[ComparedRun]) -> dict[str, object]:
    found = train_against_test(runs, "measured", "truth", np.random.default_rng(1))
    return differences_to_json(found)


def test_samples_count_in_errors() -> None:
    runs = [run(1, 1.0, count=30), run(2, 4.0, count=10)]
    assert errors_of(runs, "measured", "truth").grf.mean == pytest.approx(1.75)
    assert errors_of(runs, "measured", "measured").cop.mean == 0.0


def test_runs_count_in_the_test() -> None:
    """A run of ten thousand samples is one witness."""
    runs = [
        run(1, 1.0, name="train", count=10_000),
        run(2, 2.0, name="train"),
        run(3, 4.0),
    ]
    found = difference(runs)["grf"]
    assert isinstance(found, dict)
    assert found["difference_n"] == pytest.approx(4.0 - 1.5)
    assert found["splits"] == 3
    assert found["p_value"] == pytest.approx(1.0 / 3.0)


def test_stances_of_a_run_are_one_run() -> None:
    one, other = run(1, 1.0, count=6), run(1, 3.0, count=2)
    both = ComparedRun("a", 1, "test", {
        name: one.sources[name] + other.sources[name] for name in one.sources
    })  # fmt: skip
    assert errors_of([both], "measured", "truth").grf.mean == pytest.approx(1.5)
    found = difference([both, run(2, 2.0, name="train")])["cop"]
    assert isinstance(found, dict)
    assert found["difference_mm"] == pytest.approx(-0.5)
    assert (found["train_runs"], found["test_runs"]) == (1, 1)


def test_runs_are_compared_within_their_session() -> None:
    """Session b is 10 N worse throughout: that is no difference of the sets."""
    runs = [
        run(number, level + number % 2, name="train" if number < 4 else "test", session=session)
        for session, level in (("a", 1.0), ("b", 11.0))
        for number in range(1, 6)
    ]
    found = difference(runs)["grf"]
    assert isinstance(found, dict)
    assert abs(found["difference_n"]) < 0.2
    assert found["sessions"] == 2
    assert found["splits"] == 100


def test_by_set_and_without_one() -> None:
    sets = errors_by_set([run(1, 1.0), run(2, 3.0, name="train")], "measured", "truth")
    assert {name: found.grf.mean for name, found in sets.items()} == {"train": 3.0, "test": 1.0}
    assert set(errors_by_set([run(1, 1.0)], "measured", "truth")) == {"test"}
    assert difference([run(1, 1.0), run(2, 3.0)]) == {}


def test_a_run_that_tells_nothing_is_no_witness() -> None:
    silent = run(3, math.nan)
    found = difference([run(1, 1.0, name="train"), run(2, 2.0), silent])["grf"]
    assert isinstance(found, dict)
    assert found["test_runs"] == 1


def test_json_has_no_infinity() -> None:
    figures = difference([run(1, 1.0, name="train"), run(2, 2.0)])
    assert json.loads(json.dumps(figures, allow_nan=False))["grf"]["ci95_n"] == [None, None]
