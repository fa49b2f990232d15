"""What the table of accuracy makes of results."""

from __future__ import annotations

import numpy as np
import pytest

from accuracy_results import REFUSED, Result
from accuracy_sessions import PAPER, Case
from accuracy_tables import grouped, inside, tables
from held import WHAT, Held
from shoecal_core.estimation.series import Errors, Mae
from shoecal_core.planning.motion_sets import STANDARD


def result(seed: int, cop: float, ratio: float, gain: float, motions: str = STANDARD) -> Result:
    def mae(mean: float) -> Mae:
        return Mae(mean, 0.0, 100)

    held = Held(
        ratios={name: np.array([0.0, ratio]) for name in WHAT},
        expected=np.full(3, 1e-3), actual=np.full(3, 2e-3),
    )  # fmt: skip
    return Result(
        case=Case("default", motions, seed),
        verdict="PASS",
        seconds=2.0,
        errors=Errors(mae(0.2), mae(cop), (mae(0.1), mae(0.3)), (mae(2 * cop), mae(3 * cop))),
        gain_errors=np.array([gain - 0.01, gain + 0.01]),
        held=held,
    )


RESULTS = [result(1, 1e-3, 3.0, -0.05), result(2, 2e-3, 1.0, -0.03), result(3, 9e-3, 1.0, -0.01)]


def test_medians_shares_and_biases() -> None:
    found = tables(RESULTS)
    (row,) = found["accuracy"]
    assert row["CoP, both feet [mm]"] == "2.00 (9.00)"
    assert row["left [mm]"] == "4.00 (18.00)"
    assert row["GRF, right [N]"] == "0.30 (0.30)"
    # One of six errors is outside; calibrations are the unit of its uncertainty.
    share, half = inside([one.held for one in RESULTS if one.held is not None], "CoP")
    assert share == pytest.approx(5.0 / 6.0)
    assert half == pytest.approx(1.96 * np.std([0.5, 1.0, 1.0], ddof=1) / np.sqrt(3.0))
    assert found["intervals"][0]["CoP"] == f"83% (± {half:.0%})"
    assert str(found["gains"][0]["bias [%]"]).startswith("-3.00 ±")


def test_a_refused_session_is_counted_and_is_in_no_figure() -> None:
    refused = Result(Case("default", STANDARD, 4), REFUSED, "a cell is stuck")
    assert grouped([refused]) == {}
    found, without = tables([*RESULTS, refused])["accuracy"], tables(RESULTS)["accuracy"]
    assert found[0]["verdicts"] == "3 PASS, 1 refused"
    assert found[0]["CoP, both feet [mm]"] == without[0]["CoP, both feet [mm]"]


def test_the_papers_protocol_comes_first() -> None:
    rows = tables([*RESULTS, result(1, 1e-3, 1.0, 0.0, PAPER)])["accuracy"]
    assert [row["motions"] for row in rows] == [PAPER, STANDARD]
