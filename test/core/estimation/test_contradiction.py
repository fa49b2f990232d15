"""What is named where a joint fit does not settle, on samples whose fault is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.estimation.drawn import SETTINGS, TOLERANCES, Drawn
from shoecal_core.estimation.contradiction import NOTHING, contradiction
from shoecal_core.estimation.joint_fit import JointFit, UnsettledError, fit_jointly
from shoecal_core.samples.samples import Samples


def named(known: Drawn, samples: Samples) -> str:
    """The words, for samples whose fit does not settle."""

    def solve(runs: Sequence[int], without: frozenset[str] = frozenset()) -> JointFit:
        return fit_jointly(
            samples, runs, known.parameters, SETTINGS, TOLERANCES, 0.02, without=without
        )

    with np.errstate(all="ignore"):
        with pytest.raises(UnsettledError):
            solve(samples.runs)
        return contradiction(solve, samples, samples.runs, SETTINGS)


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
