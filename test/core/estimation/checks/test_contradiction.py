"""What is named where a joint fit does not settle, on samples whose fault is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.estimation.drawn import SETTINGS, TOLERANCES, Drawn
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.contradiction import NOTHING, contradiction
from shoecal_core.estimation.joint_fit import JointFit, UnsettledError, fit_jointly
from shoecal_core.samples.samples import Samples


def named(known: Drawn, samples: Samples, *, settles: bool = False) -> str:
    """The words, for samples whose fit does not settle, or as if it did not."""

    def solve(runs: Sequence[int], without: frozenset[str] = frozenset()) -> JointFit:
        if settles and not without and runs == samples.runs:
            raise UnsettledError("for the sake of the test")
        return fit_jointly(
            samples, runs, known.parameters, SETTINGS, TOLERANCES, 0.02, without=without
        )

    with np.errstate(all="ignore"):
        with pytest.raises(UnsettledError):
            solve(samples.runs)
        return contradiction(solve, samples, samples.runs, SETTINGS, TOLERANCES)


def tilted(samples: Samples, degrees: float) -> Samples:
    """With an IMU that shows upwards so far from where it is, in the plane of that and x."""
    up, x = samples.up, np.array((1.0, 0.0, 0.0))
    across = x - (up @ x)[:, None] * up
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.radians(degrees)
    return replace(samples, up=np.cos(angle) * up + np.sin(angle) * across)


def reading_in_the_air(samples: Samples, force: float, gain: FloatArray) -> Samples:
    """Whose lifted feet read a force in each channel [N]."""
    lifted = ~samples.loaded[:, samples.shoe.foot]
    return replace(samples, readings=samples.readings + lifted * force / gain)


def test_the_run_whose_channels_are_mixed_up_is_named(known: Drawn) -> None:
    samples = known.fit.signal_model.samples
    wrong = samples.runs[1]
    readings = samples.readings.copy()
    readings[samples.run == wrong] = readings[samples.run == wrong][:, ::-1]
    assert named(known, replace(samples, readings=readings)).startswith(
        f"run {wrong} contradicts the others: its CoP is "
    )


def test_of_noise_nothing_is_named(known: Drawn) -> None:
    samples = known.fit.signal_model.samples
    rng = np.random.default_rng(0)
    noise = replace(samples, readings=rng.normal(size=samples.readings.shape))
    assert named(known, noise) == NOTHING


def test_within_tolerance_nothing_is_named(known: Drawn) -> None:
    """Any family can be left out of a fit that settles: that alone accuses none."""
    assert named(known, known.fit.signal_model.samples, settles=True) == NOTHING


@pytest.mark.parametrize("degrees", [60.0, 120.0, 180.0])
def test_an_imu_that_is_turned_is_named_with_its_angle(known: Drawn, degrees: float) -> None:
    words = named(known, tilted(known.fit.signal_model.samples, degrees), settles=True)
    assert words.startswith("the IMU contradicts the rest: ")
    angle = float(words.split("tilted by ")[1].split(" deg")[0])
    assert angle == pytest.approx(degrees, abs=2.0)


@pytest.mark.parametrize(
    ("degrees", "force", "larger"),
    [(40.0, 0.3, "the IMU contradicts"), (2.0, 8.0, "a lifted foot contradicts")],
)
def test_the_larger_of_two_contradictions_is_named(
    known: Drawn, degrees: float, force: float, larger: str
) -> None:
    """Whichever comes first in order, and in units that cannot be compared."""
    samples = tilted(known.fit.signal_model.samples, degrees)
    samples = reading_in_the_air(samples, force, known.parameters.gain)
    assert named(known, samples, settles=True).startswith(larger)
