"""The scorer on answers and diagnoses written by hand."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from blind.answers import Answer, Category, Foreign, Truth
from blind.cases import Case
from blind.figures import Figure, calibration_error, figures, shrink_figures
from blind.intervals import bootstrap, clopper_pearson
from blind.page import confusion

LATE = Truth("latency", ("left",), {"delay": 0.02}, strength=3.0)
HEAVY = Truth("payload", ("base",), {"mass": 0.2}, strength=3.0)


def answer(category: Category, *truths: Truth, number: int = 1) -> Answer:
    foreign = Foreign("cable", 1.0, 1, 3.0) if category == "unknown" else None
    return Answer(
        number, category, 1, 101, (0, 1), 1.0, imu=True, base="default", world={}, truths=truths,
        foreign=foreign,
    )  # fmt: skip


def cause(
    effect: str, location: Sequence[str], size: Mapping[str, tuple[float, float, float]],
    *, probability: float = 0.9, run: int | None = None, group: str = "timing",
) -> dict[str, Any]:  # fmt: skip
    return {
        "effect": effect, "class": group, "location": list(location), "probability": probability,
        "run": run, "shrink": {"fraction": 0.8},
        "size": {
            name: {"value": value, "unit": "", "ci95": [low, high]}
            for name, (value, low, high) in size.items()
        },
    }  # fmt: skip


def said(verdict: str, *causes: dict[str, Any]) -> dict[str, Any]:
    first = [{key: one[key] for key in ("effect", "location")} for one in causes[:1]]
    return {
        "verdict": verdict, "causes": list(causes), "ambiguity_set": first,
        "ranking": [], "where": [], "next_motion": None,
    }  # fmt: skip


RIGHT = cause("latency", ["left"], {"delay": (0.021, 0.018, 0.024)})
WRONG = cause("payload", ["base"], {"mass": (0.3, 0.2, 0.4)}, group="body")


def case(told: Answer, diagnosis: dict[str, Any] | None, gap: float = 3.0) -> Case:
    return Case(told, gap, (2.0, 40.0), diagnosis)


def values(cases: Sequence[Case]) -> dict[str, float | None]:
    return {key: figure.value for key, figure in figures(cases).items()}


def test_a_perfect_diagnosis_meets_every_target() -> None:
    heavy = cause("payload", ["base"], {"mass": (0.2, 0.1, 0.3)}, probability=1.0, group="body")
    right = dataclasses.replace(LATE, size={"delay": 0.02})
    certain = {**RIGHT, "probability": 1.0}
    cases = [
        *[case(answer("clean"), said("no_gap"), 1.0)] * 50,
        *[case(answer("single", right), said("explained", certain))] * 10,
        *[case(answer("double", right, HEAVY), said("explained", certain, heavy))] * 10,
        *[case(answer("unknown"), said("unknown"))] * 10,
    ]
    told = figures(cases)
    missed = [
        key for key, figure in told.items() if figure.met is False and key != "intervals_hold"
    ]
    assert not missed
    assert told["intervals_hold"].value == 1.0
    assert told["set_size"].value == 1.0


def test_alarms_and_misses_are_counted() -> None:
    cases = [
        case(answer("clean"), said("no_gap"), 1.0),
        case(answer("clean"), said("explained", RIGHT), 1.0),
        case(answer("single", LATE), said("no_gap")),
        case(answer("single", LATE), said("explained", RIGHT)),
        case(answer("single", LATE), said("no_gap"), gap=1.2),
        case(answer("unknown"), said("explained", WRONG)),
    ]
    told = values(cases)
    assert told["false_alarms"] == 0.5
    assert told["found"] == pytest.approx(2 / 3)
    assert told["unknown_called_unknown"] == 0.0
    assert told["right_first"] == 1.0


def test_a_diagnosis_that_fails_is_a_miss() -> None:
    told = values([case(answer("clean"), None, 1.0), case(answer("single", LATE), None)])
    assert told["found"] == 0.0
    assert told["errors"] == 1.0


def test_exact_twins_count_as_one() -> None:
    heard = Truth("crosstalk", ("left/front_left", "left/rear_left"), {"fraction": 0.1})
    off = cause("cell_position", ["left/rear_left"], {"x": (0.001, 0.0, 0.002)}, group="load_cell")
    told = values([case(answer("single", heard), said("explained", off))])
    assert told["right_first"] == told["truth_in_set"] == told["exact_place"] == 1.0
    elsewhere = {**off, "location": ["left/front_left"]}
    told = values([case(answer("single", heard), said("explained", elsewhere))])
    assert told["right_first"] == 1.0
    assert told["truth_in_set"] == told["exact_place"] == 0.0


def test_the_root_link_has_two_names() -> None:
    found = cause("payload", ["base_link"], {"mass": (0.2, 0.1, 0.3)}, group="body")
    one = case(answer("single", HEAVY), said("explained", found))
    assert one.first_placed
    assert one.held() == [True]


def test_feet_do_not_tell_which_of_them_slipped() -> None:
    slipped = Truth("slip", ("right",), {"dx": 0.004, "time": 12.0}, run=2, onset=12.0)
    found = cause(
        "slip", ["left"], {"dx": (-0.004, -0.005, -0.003), "time": (11.5, 11.0, 12.2)}, run=2
    )
    one = case(answer("single", slipped), said("explained", found))
    assert one.first_placed
    assert one.onset_error() == pytest.approx(0.5)
    elsewhere = case(answer("single", slipped), said("explained", {**found, "run": 1}))
    assert elsewhere.onset_error() == float("inf")


def test_an_onset_counts_from_the_sessions_first_sample() -> None:
    """The simulated robot's time begins before its recording."""
    stuck = Truth("stuck_cell", ("left/front_left",), {"share": 1.0, "time": 62.0}, onset=62.0)
    found = cause("stuck_cell", ["left/front_left"], {"time": (61.0, 59.0, 63.0)})
    one = case(answer("single", stuck), said("explained", found))
    assert one.onset_error() == pytest.approx(1.0)
    assert one.held() == [True]
    there = {"signal": "grf", "run": 2, "onset_s": 21.0}
    told = {**said("unknown"), "where": [there]}
    assert case(answer("single", stuck), told).onset_error() == pytest.approx(1.0)


def test_precision_counts_every_cause_named() -> None:
    both = answer("double", LATE, HEAVY)
    tilted = cause("floor_tilt", [], {"about_x": (0.1, 0.0, 0.2)}, group="contact")
    told = values([case(both, said("explained", RIGHT, tilted)), case(both, said("no_gap"))])
    assert told["both_found"] == 0.0
    assert told["double_precision"] == 0.5


def test_shrink_is_held_against_that_of_the_true_effect() -> None:
    one = case(answer("single", LATE), said("explained", {**RIGHT, "shrink": {"fraction": 0.45}}))
    true = case(answer("single", LATE), said("explained", {**RIGHT, "shrink": {"fraction": 0.9}}))
    told = shrink_figures([(one, true)])
    assert told["shrink_median"].value == pytest.approx(0.5)
    assert told["shrink_median"].met is False


def test_confusion_names_what_was_named_first() -> None:
    cases = [
        case(answer("single", LATE), said("explained", WRONG)),
        case(answer("single", LATE), said("unknown")),
        case(answer("single", LATE), said("no_gap")),
    ]
    assert confusion(cases, by_class=True) == {"timing": {"body": 1, "unknown": 1, "nothing": 1}}


def test_calibration_error_is_the_distance_of_promise_and_share() -> None:
    rng = np.random.default_rng(1)
    probability = rng.uniform(0.0, 1.0, 20_000)
    right = rng.uniform(size=20_000) < probability
    assert calibration_error(np.column_stack([probability, right])) < 0.02
    sure = np.column_stack([np.full(100, 0.95), np.arange(100) < 50])
    assert calibration_error(sure) == pytest.approx(0.45)


def test_exact_intervals_are_those_of_the_tables() -> None:
    low, high = clopper_pearson(0, 190)
    assert low == 0.0
    assert high == pytest.approx(1.0 - 0.025 ** (1.0 / 190.0))
    assert clopper_pearson(5, 10) == pytest.approx((0.187086, 0.812914), abs=1e-6)


def test_an_interval_by_resampling_holds_the_figure() -> None:
    rows = [[float(value)] for value in range(21)]
    low, high = bootstrap(rows, lambda drawn: float(np.median(drawn)))
    assert low < 10.0 < high


def test_a_figure_without_sets_is_none() -> None:
    assert Figure("", None, None, 0).to_json()["value"] is None
    assert values([])["found"] is None
