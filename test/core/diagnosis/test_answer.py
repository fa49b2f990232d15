"""What is answered of gaps of known size, with a known cause and without."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from core.diagnosis.drawn import Urn, part
from shoecal_core.diagnosis.answer import ambiguity_set, answer, causes_of, probabilities
from shoecal_core.diagnosis.result import Candidate
from shoecal_core.diagnosis.scoring import Part
from shoecal_core.diagnosis.selection import Found
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import gap
from shoecal_core.diagnosis.workspace import Workspace

FloatArray = NDArray[np.float64]
SETTINGS = DiagnosisSettings()
NOTHING = Found(None, (), ())
TILT = {"floor_tilt": [0.01, 0.006]}
SURE = 1e5
"""Logarithm of evidence that leaves no doubt of anything in the library."""


def over_floor(workspace: Workspace, rest: FloatArray) -> float:
    """Of residuals (T, s), the larger one of CoP and GRF."""
    size = gap(workspace, rest)
    return max(size.cop_mae_mm / size.cop_floor_mm, size.grf_mae_n / size.grf_floor_n)


def with_gap(urn: Urn, over: float) -> Workspace:
    """Noise, and a floor that leans by so much that the gap is this many floors."""
    calm, tilted = (urn.draw(np.random.default_rng(1), truth) for truth in ({}, TILT))
    noise = 0.5 * calm.scene.residuals
    effect = tilted.scene.residuals - calm.scene.residuals
    # What gains and offsets leave is linear in what there is.
    left = [urn.showing(one).explained(None)[0] for one in (noise, effect)]
    low, high = 0.0, 4.0
    for _ in range(20):
        size = 0.5 * (low + high)
        less = over_floor(urn.workspace, left[0] + size * left[1]) < over
        low, high = (size, high) if less else (low, size)
    return urn.showing(noise + high * effect)


def found_in(workspace: Workspace, *labels: str, evidence: Sequence[float] = (SURE,)) -> Found:
    """The first one chosen, and all as its alternatives."""
    parts: list[Part] = [part(workspace, label) for label in labels]
    rivals = tuple((one[0], log) for one, log in zip(parts, evidence, strict=True))
    return Found(workspace.scorer.score(parts[:1]), (rivals,), ())


@pytest.mark.parametrize(
    ("over", "verdict"), [(1.1, "no_gap"), (1.3, "no_gap"), (1.47, "no_gap"), (1.53, "unknown")]
)
def test_what_nothing_explains_is_unknown_from_1_5_floors(
    urn: Urn, over: float, verdict: str
) -> None:
    drawn = with_gap(urn, over)
    assert over_floor(drawn, drawn.explained(None)[0]) == pytest.approx(over, abs=1e-3)
    assert answer(drawn, drawn, (), NOTHING, SETTINGS).verdict == verdict


@pytest.mark.parametrize(("over", "verdict"), [(1.42, "no_gap"), (1.48, "explained")])
def test_what_something_explains_is_a_gap_from_1_45_floors(
    urn: Urn, over: float, verdict: str
) -> None:
    drawn = with_gap(urn, over)
    said = answer(drawn, drawn, (), found_in(drawn, "floor_tilt"), SETTINGS)
    assert said.verdict == verdict
    assert [one.effect for one in said.causes] == ["floor_tilt"] * (verdict == "explained")


def test_however_well_one_fits_it_may_be_none_of_the_library_s(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(3), TILT)
    found = found_in(drawn, "floor_tilt")
    (only,) = probabilities(found, 0, SETTINGS)
    assert only.probability == pytest.approx(0.96)
    (cause,) = causes_of(drawn, found, drawn.explained(None)[0], SETTINGS)
    assert cause.probability == only.probability


def test_what_is_outside_takes_from_all_alike(urn: Urn) -> None:
    labels = ("floor_tilt", "latency (left)", "low_pass (left)")
    found = found_in(urn.workspace, *labels, evidence=(SURE, SURE, SURE - 2e4))
    told = probabilities(found, 0, SETTINGS)
    assert sum(one.probability for one in told) == pytest.approx(1.0 - SETTINGS.outside)
    assert told[0].probability == told[1].probability > told[2].probability
    # A set is of what the library has: what is outside makes none larger.
    assert ambiguity_set(told[:1], SETTINGS) == told[:1]


def test_a_set_holds_with_the_wanted_probability() -> None:
    ranking = tuple(
        Candidate("latency", (place,), share)
        for place, share in (("left", 0.6), ("right", 0.32), ("all", 0.04))
    )
    assert ambiguity_set(ranking, SETTINGS) == ranking[:2]
