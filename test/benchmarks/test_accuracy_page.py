"""What the table of accuracy makes of results."""

from __future__ import annotations

import numpy as np
import pytest

from accuracy_page import figures, groups, section
from accuracy_results import REFUSED, Result
from accuracy_sessions import PAPER, STANDARD, Case
from held import WHAT, Held
from shoecal_core.calibration.evaluate import Errors
from shoecal_core.calibration.metrics import Mae


def result(seed: int, cop: float, ratio: float, gain: float, motions: str = STANDARD) -> Result:
    def mae(mean: float) -> Mae:
        return Mae(mean, 0.0, 100)

    held = Held(
        ratios={name: np.array([0.0, ratio]) for name in WHAT},
        gain=np.ones(2), gain_std=np.ones(2), expected=np.full(3, 1e-3), actual=np.full(3, 2e-3),
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
    (group,) = groups(RESULTS)
    found = figures(RESULTS)["standard, default"]
    assert found == group.to_json()
    assert found["median"] == {
        "cop": pytest.approx(2.0), "left_cop": pytest.approx(4.0), "right_cop": pytest.approx(6.0),
        "left_grf": 0.1, "right_grf": 0.3, "grf": 0.2,
    }  # fmt: skip
    # One of six errors is outside; calibrations are the unit of its uncertainty.
    share, half = group.inside("CoP")
    assert share == pytest.approx(5.0 / 6.0)
    assert half == pytest.approx(1.96 * np.std([0.5, 1.0, 1.0], ddof=1) / np.sqrt(3.0))
    assert found["gain_bias"] == pytest.approx(-0.03)


def test_a_refused_session_is_named_and_counts_in_no_figure() -> None:
    refused = Result(Case("default", STANDARD, 4), REFUSED, "a cell is stuck")
    assert groups([refused]) == []
    with_it = figures([*RESULTS, refused])["standard, default"]
    assert isinstance(with_it, dict)
    assert with_it["verdicts"] == {"PASS": 3, REFUSED: 1}
    page = section([*RESULTS, refused], unrecorded=2)
    assert "standard default seed 4: a cell is stuck" in page
    assert "could not be recorded: 2" in page


def test_the_papers_protocol_comes_first_and_aims_are_counted() -> None:
    page = section([*RESULTS, result(1, 1e-3, 1.0, 0.0, PAPER)], unrecorded=0)
    assert page.index("| paper | default") < page.index("| standard | default")
    # All of the paper's errors are inside, which is more than 98 %; of the others 83 %.
    assert "it is met in 0 of 6 cells" in page
