"""Samples as equations for both feet's corrections, against formulas written out (eqs. 5, 19)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation import chunks
from shoecal_core.estimation.correction_fit import CorrectionEquations
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

TIME_OFFSET = 0.013
SUPPORTS = synthetic.SUPPORTS[:2]


@pytest.fixture
def runs(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> list[Stance]:
    """Two runs whose CoP is some millimetres off the model's."""
    clean = synthetic.stances(shoe, truth, rng, SUPPORTS, count=60)
    return [synthetic.with_model_noise(run, rng, 0.0, 3e-3) for run in clean]


def solution_and_corrections(
    equations: CorrectionEquations, rng: np.random.Generator
) -> tuple[FloatArray, list[CopCorrection]]:
    """Any parameters, as a vector and as two corrections."""
    solution = 1e-4 * rng.normal(size=len(equations.foot))
    corrections = []
    for foot in (0, 1):
        x, y = np.split(solution[equations.foot == foot], 2)
        k = len(x) - 4
        ends = np.array([[-1.0] * k, [1.0] * k])
        corrections.append(CopCorrection(foot, x, y, np.array([[-1.0] * 2, [1.0] * 2]), ends))
    return solution, corrections


def off(sensing: Sensing, run: Stance) -> FloatArray:
    """(T, 2) by how much the measured combined CoP misses the model's."""
    expected = run.cop + TIME_OFFSET * run.cop_rate
    return expected - sensing.measure(run.readings).combined_cop(run.support)


def test_the_sums_of_squares_are_those_of_the_measuring_side(
    shoe: Shoe, truth: ChannelParameters, runs: list[Stance], rng: np.random.Generator
) -> None:
    """The error's square under any corrections, once summed up and once sample by sample."""
    equations = CorrectionEquations(shoe, truth, TIME_OFFSET)
    sums = equations.sums(runs)
    before = sum(float((off(Sensing(shoe, truth), run) ** 2).sum()) for run in runs)
    for _ in range(3):
        solution, corrections = solution_and_corrections(equations, rng)
        sensing = Sensing(shoe, truth, corrections)
        after = sum(float((off(sensing, run) ** 2).sum()) for run in runs)
        summed = before - 2.0 * solution @ sums.right + solution @ sums.matrix @ solution
        assert summed == pytest.approx(after, rel=1e-9)


def test_errors_count_by_each_foot_s_share(
    shoe: Shoe, truth: ChannelParameters, runs: list[Stance], rng: np.random.Generator
) -> None:
    equations = CorrectionEquations(shoe, truth, TIME_OFFSET)
    solution, corrections = solution_and_corrections(equations, rng)
    found = equations.errors(runs, np.stack((np.zeros_like(solution), solution)))
    for choice, sensing in enumerate((Sensing(shoe, truth), Sensing(shoe, truth, corrections))):
        length = np.concatenate([np.linalg.norm(off(sensing, run), axis=1) for run in runs])
        grf = np.concatenate([sensing.measure(run.readings).grf for run in runs])
        share = grf / grf.sum(axis=1, keepdims=True)
        expected = (share * length[:, None]).sum(axis=0) / share.sum(axis=0)
        np.testing.assert_allclose(found[choice], expected)


@pytest.mark.parametrize("chunk", [1, 7, 59])
def test_chunks_do_not_change_the_result(
    shoe: Shoe, truth: ChannelParameters, runs: list[Stance], rng: np.random.Generator,
    chunk: int, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    equations = CorrectionEquations(shoe, truth, TIME_OFFSET)
    solutions = solution_and_corrections(equations, rng)[0][None]
    whole, errors = equations.sums(runs), equations.errors(runs, solutions)
    monkeypatch.setattr(chunks, "CHUNK", chunk)
    parts = equations.sums(runs)
    np.testing.assert_allclose(parts.matrix, whole.matrix, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(parts.right, whole.right, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(parts.low, whole.low, rtol=1e-12)
    np.testing.assert_allclose(parts.high, whole.high, rtol=1e-12)
    assert parts.samples == whole.samples == 120
    assert parts.duration == pytest.approx(whole.duration)
    np.testing.assert_allclose(equations.errors(runs, solutions), errors, rtol=1e-12)


def test_runs_add_up(shoe: Shoe, truth: ChannelParameters, runs: list[Stance]) -> None:
    equations = CorrectionEquations(shoe, truth, TIME_OFFSET)
    one, other, both = (equations.sums(part) for part in (runs[:1], runs[1:], runs))
    total = one + other
    np.testing.assert_allclose(total.matrix, both.matrix, rtol=1e-12)
    np.testing.assert_allclose(total.right, both.right, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(total.low, both.low, rtol=1e-12)
    np.testing.assert_allclose(total.high, both.high, rtol=1e-12)
    assert total.duration == pytest.approx(6.0)


def test_samples_without_a_cop_of_both_feet_are_left_out(
    shoe: Shoe, truth: ChannelParameters, runs: list[Stance], rng: np.random.Generator
) -> None:
    equations = CorrectionEquations(shoe, truth, TIME_OFFSET)
    run = runs[0]
    empty = -truth.offset / truth.gain
    lifted = run.readings.copy()
    lifted[:20, shoe.of_foot(1)] = empty[shoe.of_foot(1)]
    half, rest = equations.sums([replace(run, readings=lifted)]), equations.sums([run.part(
        slice(20, None)
    )])  # fmt: skip
    np.testing.assert_allclose(half.matrix, rest.matrix)
    assert half.samples == 40
    assert half.duration == pytest.approx(2.0)
    single = synthetic.single_stance(shoe, truth, 0, rng)
    for nothing in ([], [single], [run.part(slice(0, 0))]):
        assert equations.sums(nothing).samples == 0


def test_a_six_axis_foot_has_its_force_and_two_moments() -> None:
    origin = [0.01, 0.0, 0.1]
    shoe = shoes.made(
        shoes.six_axis(0, origin) + shoes.cells(1, [(0.1, 0.0), (0.0, 0.05), (-0.1, 0.0)])
    )
    rng = np.random.default_rng(8)
    parameters = ChannelParameters(np.full(8, 2.0), np.full(8, 0.1))
    equations = CorrectionEquations(shoe, parameters, TIME_OFFSET)
    # Four terms of the polynomial and three channels, in x and in y.
    np.testing.assert_array_equal(np.bincount(equations.foot), [2 * (4 + 3), 2 * (4 + 3)])
    readings = rng.normal(size=(60, 8))
    readings[:, [2, 5, 6, 7]] += 10.0
    run = replace(synthetic.stance(shoe, parameters, SUPPORTS[1], rng, count=60), readings=readings)
    solution, corrections = solution_and_corrections(equations, rng)
    sums = equations.sums([run])
    before, after = (
        float((off(sensing, run) ** 2).sum())
        for sensing in (Sensing(shoe, parameters), Sensing(shoe, parameters, corrections))
    )
    summed = before - 2.0 * solution @ sums.right + solution @ sums.matrix @ solution
    assert summed == pytest.approx(after, rel=1e-9)
    left = equations.correction(0, solution, sums)
    assert left.channels == 3
    outputs = parameters.outputs(readings)[:, 2:5]
    np.testing.assert_allclose(left.output_range, [outputs.min(axis=0), outputs.max(axis=0)])
    np.testing.assert_array_equal(left.x, corrections[0].x)
