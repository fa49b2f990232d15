"""Gears that give, and joints' zeros that are off: whether they are told apart."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from core.error_sources import world
from core.estimation import synthetic
from core.estimation.drawn import PUSHED, SETTINGS, TOLERANCES
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.usable import check_robot
from shoecal_core.estimation.freed_gears import GEARS, free_gears
from shoecal_core.estimation.joint_fit import JointFit, fit_jointly

COMPLIANCE, PLAY, ZERO = 0.012, 0.010, 0.030
GEAR_NAMES = {gear.identifier for gear in GEARS}


def fitted(joint: str = "", share: float = 1.0, seed: int = 3) -> JointFit:
    """Of a robot whose motors give way to the forces between its feet: what gears give by shows in
    the joint angles, however the soles are held.

    Args:
        joint: whose zero is off; empty: none's is.
        share: of what the gears give by.
        seed: of motion, gears and noise.
    """
    rng = np.random.default_rng(seed)
    moves = world.motion(rng, supports=5, unloading=2, count=24)
    parameters = synthetic.truth(moves.shoe, rng)
    names = moves.robot.joint_names
    legs = np.isin(np.arange(len(names)), moves.robot.moved)
    unlike = share * legs * rng.uniform(0.4, 1.6, (2, len(names)))
    zero = ZERO * (np.array(names) == joint)

    def shown(torque: FloatArray) -> FloatArray:
        play = 0.5 * PLAY * unlike[1] * np.tanh(torque / PUSHED)
        found: FloatArray = zero + COMPLIANCE * unlike[0] * torque + play
        return found

    truth = world.Truth(parameters, encoder=shown, noise=0.01)
    samples = world.recorded(moves, truth, seed)
    return fit_jointly(
        samples, samples.runs, parameters, SETTINGS, TOLERANCES, time_offset_std_s=0.02
    )


def reasons(fit: JointFit) -> list[str]:
    """What is said of the robot."""
    return [one.reason for one in check_robot(fit.deviations, partial(free_gears, fit, TOLERANCES))]


@pytest.mark.parametrize("seed", [3, 4])
def test_gears_that_give_are_not_told_as_zeros_that_are_off(seed: int) -> None:
    """The joint fit takes them for zeros that are off by 80 mrad and more."""
    fit = fitted(seed=seed)
    (alone,) = check_robot(fit.deviations)
    assert "RKneePitch is off by" in alone.reason
    assert "gears give and have play, which turns links by" not in alone.reason
    (told,) = reasons(fit)
    assert "or gears give and have play, which turns links by" in told
    assert "% of the misfit, so it is likelier" in told
    assert "hold the motors and push the links" in told


def test_how_far_gears_give_is_found() -> None:
    """In the mean of all joints, by which a person looks for it."""
    fit = fitted()
    freed = free_gears(fit, TOLERANCES)
    legs = fit.signal_model.samples.robot.moved
    # Compliance and play of all joints in the mean, under the torques of the samples.
    torque = fit.signal_model.torque[:, legs]
    true = COMPLIANCE * torque + 0.5 * PLAY * np.tanh(torque / PUSHED)
    wanted = np.sqrt(np.mean(true**2, axis=0)).mean()
    assert np.mean(list(freed.given.values())) == pytest.approx(wanted, rel=0.4)
    assert freed.cost_share < 0.05
    kept = [one.deviation.key for one in fit.deviations if one.deviation.effect not in GEAR_NAMES]
    assert [one.deviation.key for one in freed.deviations] == kept


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_a_zero_that_is_off_is_named_by_itself_where_gears_may_give(seed: int) -> None:
    """One of 30 mrad; what else was taken for zeros is told apart from it."""
    named, others = reasons(fitted("LKneePitch", 0.1, seed))
    assert named.startswith("by the fit the zero of LKneePitch is off by ")
    assert "or gears give" not in named
    assert named.count("zero of") == 1
    assert "LKneePitch is off" not in others


def test_exact_gears_stay_exact() -> None:
    """Where tolerances say that nothing gives, nothing is said to."""
    exact = replace(TOLERANCES, gear_compliance_rad_per_nm=0.0, gear_play_rad=0.0)
    freed = free_gears(fitted(share=0.1), exact)
    assert max(freed.given.values()) < 1e-5
