"""Which found effects are fitted: what the diagnosis is sure of, what training runs bear out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shoecal_core.calibration.refinement.choice import STRONG, choose
from shoecal_core.calibration.refinement.found_effects import FoundEffect, FoundEffects
from shoecal_core.calibration.refinement.refine import Evidence
from shoecal_core.calibration.refinement.refined import Refined, refined
from shoecal_core.calibration.refinement.unknowns import Unknown, column_change

from core.calibration.test_refinement import ROBOT, SETTINGS, SHOE, made, standing_still
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.samples.stance import Stance

PLACE, TURN = 0.01, 0.02
FIRST = FoundEffect("cell_position", ("left/front_left",), {"x": (PLACE, 5e-4)}, 0.4)
SECOND = FoundEffect("joint_offset", ("LAnkleRoll",), {"angle": (TURN, 0.001)}, 0.4)
WRONG = FoundEffect(
    "crosstalk", ("right/front_left", "right/rear_left"), {"fraction": (0.15, 0.02)}, 0.4
)
CELL = Unknown("cell_position", FIRST.location, "x", 0.0, 0.005)


def gaining(
    gains: dict[str, float], misfit: float = 1.0
) -> Callable[[Sequence[FoundEffect]], Evidence]:
    """Each effect adds its own to the evidence."""
    return lambda some: Evidence(-50.0 + sum(gains[one.effect] for one in some), misfit)


def nothing_is_sure(_: FoundEffect) -> bool:
    return False


@pytest.mark.parametrize(
    ("first", "second", "fitted"),
    [
        (5.0, 4.0, (FIRST, SECOND)),
        (5.0, 2.0, (FIRST,)),
        (-1.0, 4.0, (SECOND,)),
        (2.9, 2.9, ()),
        (0.0, 0.0, ()),
    ],
)
def test_each_doubtful_effect_needs_strong_evidence(
    first: float, second: float, fitted: tuple[FoundEffect, ...]
) -> None:
    evidence = gaining({"cell_position": first, "joint_offset": second})
    choice = choose((FIRST, SECOND), nothing_is_sure, evidence)
    assert choice.fitted == fitted
    assert choice.left_out == tuple(one for one in (FIRST, SECOND) if one not in fitted)
    assert [one.effects for one in choice.tried] == [(FIRST,), (SECOND,), (FIRST, SECOND)]


def test_two_that_only_help_together() -> None:
    def evidence(some: Sequence[FoundEffect]) -> Evidence:
        return Evidence(7.0 if len(some) == 2 else 1.0 * len(some), 1.0)

    assert choose((FIRST, SECOND), nothing_is_sure, evidence).fitted == (FIRST, SECOND)


@given(st.floats(-100.0, 100.0), st.floats(0.1, 100.0))
def test_large_residuals_make_evidence_count_less(gain: float, misfit: float) -> None:
    choice = choose((FIRST,), nothing_is_sure, gaining({"cell_position": gain}, misfit))
    (tried,) = choice.tried
    assert tried.gain == pytest.approx(gain / max(1.0, misfit), abs=1e-9)
    assert bool(choice.fitted) == (tried.gain > STRONG)


def test_what_is_sure_is_fitted_whatever_the_runs_say() -> None:
    evidence = gaining({"cell_position": -9.0, "joint_offset": -9.0})
    alone = choose((FIRST,), lambda _: True, evidence)
    assert (alone.fitted, alone.tried) == ((FIRST,), ())
    beside = choose((SECOND, FIRST), lambda one: one is FIRST, evidence)
    assert (beside.fitted, beside.left_out) == ((FIRST,), (SECOND,))
    assert [one.gain for one in beside.tried] == [-9.0]


def test_it_is_told() -> None:
    evidence = gaining({"cell_position": 6.0, "joint_offset": -1.0})
    choice = choose((FIRST, SECOND), nothing_is_sure, evidence)
    assert choice.told == (
        "found effects that are fitted: cell_position (left/front_left); that are not: "
        "joint_offset (LAnkleRoll) (log evidence of the training runs: "
        "+6.0 with cell_position (left/front_left), -1.0 with joint_offset (LAnkleRoll), "
        "+5.0 with cell_position (left/front_left) and joint_offset (LAnkleRoll); 3 each is strong)"
    )
    figures = choice.to_json()
    assert (figures["fitted"], figures["left_out"]) == ([FIRST.label], [SECOND.label])
    assert isinstance(figures["tried"], list)
    assert figures["tried"][1] == {"effects": [SECOND.label], "log_evidence": -1.0}
    assert choose((), nothing_is_sure, evidence).told == ""
    assert choose((FIRST,), lambda _: True, evidence).told.endswith(FIRST.label)


def recorded(place: float = 0.0) -> list[Stance]:
    """Three double supports, and each foot in the air; a cell is not where the file says."""
    worn = SHOE.with_columns(SHOE.columns + place * column_change(CELL, SHOE))
    stances = made(worn)[1]
    return [*standing_still(stances[:3]), *(_held(one) for one in stances[3:])]


def _held(stance: Stance) -> Stance:
    """Its first sample for all the time."""
    first = np.zeros(len(stance.time), dtype=np.int64)
    return replace(
        stance,
        readings=stance.readings[first],
        force=stance.force[first],
        cop=stance.cop[first],
        cop_rate=np.zeros_like(stance.cop),
    )


def refinement(stances: Sequence[Stance], verdict: str, *effects: FoundEffect) -> Refined:
    found = FoundEffects(ROBOT.name, SHOE.name, verdict, effects)
    return refined(ROBOT, SHOE, stances, found, SETTINGS, Tolerances())


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_large_effect_is_borne_out_and_a_wrong_one_is_not(sign: float) -> None:
    """That it is there, the runs tell; not the size that the diagnosis found in the same runs."""
    stances = recorded(sign * PLACE)
    choice = refinement(stances, "ambiguous", WRONG, FIRST).choice
    assert choice.fitted == (FIRST,)
    assert choice.left_out == (WRONG,)


def test_with_a_perfect_model_nothing_doubtful_is_fitted() -> None:
    choice = refinement(recorded(), "ambiguous", FIRST, WRONG, SECOND).choice
    assert choice.fitted == ()
    assert all(one.gain < 0.0 for one in choice.tried)


def test_the_calibration_is_better_for_a_large_effect() -> None:
    """Whether it was sure, or chosen."""
    stances = recorded(PLACE)
    truth = SHOE.columns + PLACE * column_change(CELL, SHOE)

    def off(result: Refined) -> float:
        return float(np.abs(result.refinement.shoe.columns - truth).max())

    alone = off(refinement(stances, "ambiguous"))
    for verdict, probability in (("explained", 0.95), ("ambiguous", 0.4)):
        effect = replace(FIRST, probability=probability)
        assert off(refinement(stances, verdict, effect)) < 0.5 * alone


def test_what_is_sure() -> None:
    sure = replace(FIRST, probability=0.95)
    for effect, verdict, tried in (
        (sure, "explained", 0),
        (FIRST, "explained", 1),
        (sure, "ambiguous", 1),
        (sure, "partly_explained", 1),
    ):
        assert len(refinement(recorded(), verdict, effect).choice.tried) == tried


def test_an_effect_that_is_not_fitted_changes_nothing() -> None:
    stances = recorded()
    alone, beside = (refinement(stances, "ambiguous", *some) for some in ((), (WRONG,)))
    assert beside.choice.left_out == (WRONG,)
    assert alone.to_json() == beside.to_json()
    np.testing.assert_array_equal(alone.refinement.shoe.columns, beside.refinement.shoe.columns)
