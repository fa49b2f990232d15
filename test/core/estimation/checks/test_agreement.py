"""A calibration is borne out by the robot's weight, or contradicted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation.standing import BOTH, TOLERANCE, WEIGHT, calibration, stand
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.agreement import (
    CONTRADICTION_SHARE,
    DOUBT_SHARE,
    Agreement,
    Judgement,
    judge,
)
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workspace import config_dir

SHOE = load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")
ROBOT = replace(load_robot(config_dir() / "robots" / "nao.yaml", SHOE), mass=WEIGHT / GRAVITY)
COUNT = len(SHOE.names)
TRUTH = ChannelParameters(np.where(SHOE.polarity > 0, 12.0, -12.0), np.linspace(-2.0, 2.0, COUNT))
COVARIANCE = 0.01 * np.eye(2 * COUNT)
SAMPLES = 100


def judged(
    law: ChannelParameters,
    *,
    forces: tuple[float, float] = BOTH,
    noise: float = 0.0,
    ramp: float = 0.0,
    off: FloatArray | None = None,
    covariance: FloatArray | None = COVARIANCE,
    still: bool = True,
) -> Agreement | None:
    """By a second with noise, and a force that grows by `ramp`, on each cell [N]."""
    standing = stand(SHOE, forces, off=off)
    felt = standing.felt + np.linspace(0.0, ramp, SAMPLES)[:, None]
    felt = felt + np.random.default_rng(1).normal(0.0, noise, felt.shape)
    return judge(
        calibration(SHOE, law, covariance=covariance),
        ROBOT,
        SHOE,
        (felt - TRUTH.offset) / TRUTH.gain,
        standing.body if still else None,
        TOLERANCE,
    )


def shifted(newtons: float) -> ChannelParameters:
    """Offsets that add up to so much more."""
    return replace(TRUTH, offset=TRUTH.offset + newtons / COUNT)


@pytest.mark.parametrize("still", [True, False])
@pytest.mark.parametrize("forces", [BOTH, (WEIGHT, 0.0), (0.0, WEIGHT)])
def test_the_truth_agrees(forces: tuple[float, float], still: bool) -> None:
    found = judged(TRUTH, forces=forces, noise=0.05, still=still)
    assert found is not None
    assert found.judgement is Judgement.AGREES
    assert (found.cop is not None) == still
    assert "N off the weight" in found.reason


@pytest.mark.parametrize("scale", [None, 0.0, 1e-9, 1.0, 1e3, 1e9])
def test_bounds_hold_whatever_is_stated(scale: float | None) -> None:
    covariance = None if scale is None else scale * COVARIANCE
    for share, expected in (
        (0.9 * DOUBT_SHARE, {Judgement.AGREES}),
        (1.1 * DOUBT_SHARE, {Judgement.AGREES, Judgement.DISAGREES}),
        (1.1 * CONTRADICTION_SHARE, {Judgement.CONTRADICTS}),
    ):
        for sign in (-1.0, 1.0):
            found = judged(shifted(sign * share * WEIGHT), covariance=covariance)
            assert found is not None
            assert found.judgement in expected, (share, found)


def test_what_is_stated_counts_between_them() -> None:
    law = shifted(0.03 * WEIGHT)
    sure, unsure = (judged(law, covariance=scale * COVARIANCE) for scale in (0.01, 10.0))
    assert sure is not None
    assert unsure is not None
    assert (sure.judgement, unsure.judgement) == (Judgement.DISAGREES, Judgement.AGREES)


def test_a_cop_that_the_model_contradicts() -> None:
    bound = 0.5 * min(foot.half_width for foot in ROBOT.feet)
    for size, expected in ((0.4, Judgement.AGREES), (1.1, Judgement.CONTRADICTS)):
        found = judged(TRUTH, off=np.array([0.6, -0.8]) * size * bound)
        assert found is not None
        assert found.judgement is expected
        assert found.grf.judgement is Judgement.AGREES
        assert "mm off the model" in found.reason


def test_in_the_air_nothing_is_judged() -> None:
    assert judged(TRUTH, forces=(0.0, 0.0), noise=0.05, still=False) is None
    assert judged(shifted(0.9 * CONTRADICTION_SHARE * WEIGHT), forces=(0.0, 0.0)) is None


@pytest.mark.parametrize("noise", [0.05, 0.5, 1.0])
def test_noise_of_cheap_cells_is_neither_motion_nor_load(noise: float) -> None:
    found = judged(TRUTH, noise=noise)
    assert found is not None
    assert found.judgement is Judgement.AGREES
    assert judged(TRUTH, forces=(0.0, 0.0), noise=noise) is None


def test_a_hanging_robot_whose_feet_read_a_force_contradicts() -> None:
    found = judged(shifted(1.1 * CONTRADICTION_SHARE * WEIGHT), forces=(0.0, 0.0))
    assert found is not None
    assert found.judgement is Judgement.CONTRADICTS


@pytest.mark.parametrize("ramp", [-WEIGHT, -0.3 * WEIGHT, 0.3 * WEIGHT])
def test_a_robot_that_is_lifted_or_pushed_is_not_judged(ramp: float) -> None:
    assert judged(TRUTH, ramp=ramp / COUNT) is None


def test_noise_of_gains_that_are_far_too_large_hides_nothing() -> None:
    law = ChannelParameters(100.0 * TRUTH.gain, TRUTH.offset)
    found = judged(law, noise=0.05)
    assert found is not None
    assert found.judgement is Judgement.CONTRADICTS
