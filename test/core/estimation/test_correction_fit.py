"""The CoP correction inside the combined CoP (paper, eqs. 19 and 20)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation import correction_fit as module
from shoecal_core.estimation.correction_fit import fit_corrections
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

Feet = tuple[float, float]
CORRECTED = CalibrationSettings(correction_std_m=1e-3)
FREE = CalibrationSettings(cop_std_m=1e-7, correction_std_m=1.0)
"""Hardly any damping: for samples without error."""


def bent(shoe: Shoe, foot: int, rng: np.random.Generator) -> CopCorrection:
    """A plate that bends: some millimetres, by place and by load."""
    count = len(shoe.of_foot(foot))
    typical = np.array([0.5, 0.05, 0.05, 2e-3, *np.full(count, 1e-4)])
    everywhere = np.array([[-1.0, -1.0], [1.0, 1.0]])
    return CopCorrection(
        foot,
        typical * rng.normal(size=len(typical)),
        typical * rng.normal(size=len(typical)),
        everywhere,
        np.array([[-1e3] * count, [1e3] * count]),
    )


def bent_runs(
    shoe: Shoe,
    truth: ChannelParameters,
    corrections: list[CopCorrection],
    seed: int = 5,
    noise: float = 0.0,
) -> list[Stance]:
    rng = np.random.default_rng(seed)
    runs = [
        synthetic.with_corrections(run, shoe, truth, corrections)
        for run in synthetic.stances(shoe, truth, rng)
    ]
    return [synthetic.with_model_noise(run, rng, 0.0, noise) for run in runs]


def off(sensing: Sensing, runs: Sequence[Stance]) -> float:
    """Mean error of the combined CoP [m]."""
    errors = [
        np.linalg.norm(sensing.measure(run.readings).combined_cop(run.support) - run.cop, axis=1)
        for run in runs
    ]
    return float(np.mean(np.concatenate(errors)))


def test_what_was_bent_is_straightened(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    true = [bent(shoe, 0, rng), bent(shoe, 1, rng)]
    found = fit_corrections(shoe, truth, 0.0, bent_runs(shoe, truth, true), FREE)
    assert [correction.foot for correction in found] == [0, 1]
    # On runs it has never seen, too.
    others = bent_runs(shoe, truth, true, seed=6)
    assert off(Sensing(shoe, truth), others) > 1e-3
    assert off(Sensing(shoe, truth, found), others) < 2e-6


@pytest.mark.parametrize("foot", [0, 1])
def test_the_bent_foot_is_found_among_model_errors(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, foot: int
) -> None:
    true = [bent(shoe, foot, rng)]
    runs = bent_runs(shoe, truth, true, noise=3e-4)
    found = fit_corrections(shoe, truth, 0.0, runs, CORRECTED)
    assert foot in [correction.foot for correction in found]
    others = bent_runs(shoe, truth, true, seed=6)
    assert off(Sensing(shoe, truth, found), others) < 0.5 * off(Sensing(shoe, truth), others)


def test_noise_is_not_corrected(shoe: Shoe, truth: ChannelParameters) -> None:
    for seed in range(3):
        runs = bent_runs(shoe, truth, [], seed=seed, noise=2e-3)
        assert fit_corrections(shoe, truth, 0.0, runs, CORRECTED) == ()


def test_what_helps_only_the_runs_it_was_fitted_to_is_left_out(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    """The plate bends to and fro from run to run: each is mispredicted from the others."""
    to = bent(shoe, 0, rng)
    fro = replace(to, x=-to.x, y=-to.y)
    runs = [
        synthetic.with_corrections(run, shoe, truth, [(to, fro)[run.run % 2]])
        for run in synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:4])
    ]
    assert fit_corrections(shoe, truth, 0.0, runs, CORRECTED) == ()


def test_a_little_help_is_not_enough(
    shoe: Shoe, truth: ChannelParameters, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half a millimetre under two millimetres of noise: one or two per cent better."""
    count = len(shoe.of_foot(0))
    shifted = replace(
        bent(shoe, 0, np.random.default_rng(0)),
        x=np.array([0.0, 0.0, 0.0, 8e-4, *np.zeros(count)]),
        y=np.zeros(4 + count),
    )
    runs = bent_runs(shoe, truth, [shifted], noise=2e-3)
    assert fit_corrections(shoe, truth, 0.0, runs, CORRECTED) == ()
    monkeypatch.setattr(module, "MINIMUM_GAIN", 0.0)
    assert fit_corrections(shoe, truth, 0.0, runs, CORRECTED) != ()


def by_choice(none: Feet, left: Feet, right: Feet, both: Feet) -> dict[tuple[int, ...], FloatArray]:
    """Errors [mm] while the left and while the right foot carries."""
    return dict(zip(module.CHOICES, map(np.array, (none, left, right, both)), strict=True))


@pytest.mark.parametrize(
    ("errors", "chosen"),
    [
        # Both help, each its own foot.
        (by_choice((3.0, 3.0), (2.0, 2.8), (2.8, 2.0), (1.8, 1.8)), (0, 1)),
        # The right foot's helps the left a lot, but the right foot itself by too little.
        (by_choice((3.0, 3.0), (2.9, 2.9), (2.0, 2.9), (2.0, 2.9)), ()),
        # The left foot's worsens the right foot.
        (by_choice((3.0, 3.0), (1.0, 3.1), (2.9, 2.8), (1.0, 3.0)), (1,)),
        # Together they are no better than the left foot's alone.
        (by_choice((3.0, 3.0), (2.0, 2.5), (2.9, 2.8), (2.0, 2.45)), (0,)),
        # Either helps, but not both: the better one.
        (by_choice((3.0, 3.0), (2.7, 2.7), (2.5, 2.5), (2.5, 2.5)), (1,)),
        (by_choice((3.0, 3.0), (3.0, 3.0), (3.0, 3.0), (3.0, 3.0)), ()),
    ],
)
def test_each_foot_must_be_the_better_for_its_own(
    errors: dict[tuple[int, ...], FloatArray], chosen: tuple[int, ...]
) -> None:
    assert module._best(errors) == chosen


def test_it_is_the_damped_least_squares_of_all_samples(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    """Rows written out and stacked, the damping as further rows."""
    true = [bent(shoe, 0, rng), bent(shoe, 1, rng)]
    runs = bent_runs(shoe, truth, true, noise=1e-3)
    settings = CORRECTED
    found = fit_corrections(shoe, truth, 0.01, runs, settings)
    assert len(found) == 2
    rows, targets = [], []
    for run in runs:
        measured = Sensing(shoe, truth).measure(run.readings)
        share = measured.grf / measured.total_grf[:, None]
        outputs = truth.outputs(run.readings)
        parts = []
        for foot, turn in ((0, np.eye(2)), (1, run.support.rotation)):
            x, y = measured.cop[:, foot].T
            f, one = outputs[:, shoe.of_foot(foot)].T, np.ones_like(x)
            in_x, in_y = np.array([x**2, x, y, one, *f]), np.array([y**2, y, x, one, *f])
            both = [np.vstack((turn[axis, 0] * in_x, turn[axis, 1] * in_y)) for axis in (0, 1)]
            parts.append(share[:, foot] * np.array(both))
        rows.append(np.concatenate(parts, axis=1).transpose(0, 2, 1).reshape(-1, sum(
            len(part[0]) for part in parts
        )))  # fmt: skip
        expected = run.cop + 0.01 * run.cop_rate
        targets.append((expected - measured.combined_cop(run.support)).T.reshape(-1))
    matrix, target = np.concatenate(rows), np.concatenate(targets)
    size = np.sqrt((matrix**2).mean(axis=0))
    seconds = len(target) / 2 / synthetic.RATE
    damping = len(target) / 2 / (seconds / settings.correlation_s)
    damping *= (settings.cop_std_m / settings.correction_std_m) ** 2
    solution = np.linalg.lstsq(
        np.vstack((matrix / size, np.sqrt(damping) * np.eye(len(size)))),
        np.concatenate((target, np.zeros(len(size)))),
        rcond=None,
    )[0] / size  # fmt: skip
    everything = np.concatenate([np.concatenate((one.x, one.y)) for one in found])
    np.testing.assert_allclose(everything, solution, rtol=1e-6, atol=1e-9)


def test_nothing_can_be_held_out_of_one_run(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng)])
    assert fit_corrections(shoe, truth, 0.0, runs[:1], FREE) == ()
    # Two stances of one run are one run.
    again = replace(runs[1], run=runs[0].run)
    assert fit_corrections(shoe, truth, 0.0, [runs[0], again], FREE) == ()
    assert fit_corrections(shoe, truth, 0.0, [], FREE) == ()


def test_it_can_be_turned_off(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng)])
    settings = CalibrationSettings(correction_std_m=0.0)
    assert fit_corrections(shoe, truth, 0.0, runs, settings) == ()


def test_damping_keeps_it_small(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng), bent(shoe, 1, rng)])

    def size(std: float) -> float:
        settings = CalibrationSettings(correction_std_m=std)
        found = Sensing(shoe, truth, fit_corrections(shoe, truth, 0.0, runs, settings))
        plain = Sensing(shoe, truth)
        return float(np.mean([
            np.nanmean(np.abs(found.measure(r.readings).cop - plain.measure(r.readings).cop))
            for r in runs
        ]))  # fmt: skip

    assert size(1e-4) < size(1e-3) < size(1e-2)


def test_the_rate_of_samples_does_not_change_the_damping(
    truth: ChannelParameters, shoe: Shoe, rng: np.random.Generator
) -> None:
    true = [bent(shoe, 0, rng), bent(shoe, 1, rng)]

    def at(rate: float) -> list[CopCorrection]:
        draw = np.random.default_rng(3)
        runs = synthetic.stances(shoe, truth, draw, rate=rate, count=round(20 * rate))
        runs = [synthetic.with_corrections(run, shoe, truth, true) for run in runs]
        return list(fit_corrections(shoe, truth, 0.0, runs, CORRECTED))

    slow, fast = at(20.0), at(100.0)
    for one, other in zip(slow, fast, strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=0.03, atol=0.03 * np.abs(one.x).max())


def test_the_time_offset_is_taken_into_account(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    """Joints late by 30 ms look like a CoP error that a correction must not chase."""
    true = [bent(shoe, 0, rng), bent(shoe, 1, rng)]
    runs = [replace(run, cop=run.cop - 0.03 * run.cop_rate) for run in bent_runs(shoe, truth, true)]
    found = fit_corrections(shoe, truth, 0.03, runs, FREE)
    others = bent_runs(shoe, truth, true, seed=6)
    assert off(Sensing(shoe, truth, found), others) < 2e-6


def test_it_remembers_where_it_was_trained(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng), bent(shoe, 1, rng)])
    found = fit_corrections(shoe, truth, 0.0, runs, FREE)
    outputs = truth.outputs(np.concatenate([run.readings for run in runs]))
    sensing = Sensing(shoe, truth, found)
    for correction in found:
        own = outputs[:, shoe.of_foot(correction.foot)]
        np.testing.assert_allclose(correction.output_range, [own.min(axis=0), own.max(axis=0)])
    for run in runs:
        assert not sensing.measure(run.readings).extrapolating.any()
    heavy = (2.0 * outputs[0] - truth.offset) / truth.gain
    assert sensing.measure(heavy).extrapolating.any()


def test_single_supports_and_unloaded_feet_take_no_part(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng), bent(shoe, 1, rng)])
    lifted = synthetic.single_stance(shoe, truth, 0, rng, run=9)
    floating = replace(
        synthetic.stance(shoe, truth, synthetic.SUPPORTS[0], rng, run=10), readings=np.tile(
            -truth.offset / truth.gain, (400, 1)
        )
    )  # fmt: skip
    plain = fit_corrections(shoe, truth, 0.0, runs, FREE)
    more = fit_corrections(shoe, truth, 0.0, [*runs, lifted, floating], FREE)
    for one, other in zip(plain, more, strict=True):
        np.testing.assert_array_equal(one.x, other.x)
        np.testing.assert_array_equal(one.y, other.y)


def test_feet_with_other_numbers_of_cells_keep_their_own_terms(
    rng: np.random.Generator,
) -> None:
    shoe = shoes.shoe("odd_shoe")
    truth = synthetic.truth(shoe, rng)
    runs = bent_runs(shoe, truth, [bent(shoe, 0, rng), bent(shoe, 1, rng)])
    left, right = fit_corrections(shoe, truth, 0.0, runs, FREE)
    assert (left.channels, right.channels) == (3, 6)
