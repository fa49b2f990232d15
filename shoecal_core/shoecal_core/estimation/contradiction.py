"""Which signals contradict the others, where a joint fit does not settle.

Each family of signals, and each run, is left out in turn. Where the rest can be fitted, what was
left out is what contradicts it, by as much as it is off that fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.signals import COP, FAMILIES
from shoecal_core.estimation.joint_fit import JointFit, UnsettledError
from shoecal_core.samples.samples import Samples

Solve = Callable[[Sequence[int], frozenset[str]], JointFit]
"""Fits some runs without some families of signals, or raises an `UnsettledError`."""
LEAST_RUNS = 3
"""Runs from which one can be left out."""
NOTHING = (
    "neither the IMU, nor the legs' joints, nor the fourth cell of each foot, nor a lifted foot, "
    "nor any one run is it alone that contradicts the rest: run `shoecal check SESSION`, and see "
    "that robot and shoe files are those of what was recorded"
)


def contradiction(
    solve: Solve, samples: Samples, train: Sequence[int], settings: SignalSettings
) -> str:
    """What contradicts the rest, by how much, and what to do, in words.

    Args:
        solve: the fit that did not settle.
        samples: of all runs. train: those that were fitted.
        settings: of the signals.
    """
    for family, part in FAMILIES.items():
        try:
            fit = solve(train, frozenset((family,)))
        except UnsettledError:
            continue
        off = _off(fit, samples, train, settings)[:, part]
        if np.isfinite(off).any():
            return _WORDS[family](off)
    for run in train if len(train) >= LEAST_RUNS else ():
        try:
            fit = solve([one for one in train if one != run], frozenset())
        except UnsettledError:
            continue
        off = _off(fit, samples, (run,), settings)
        return (
            f"run {run} contradicts the others: its CoP is {1e3 * _length(off[:, COP]):.0f} mm off "
            "the model that they fit; leave it out (--train), or see what was different in it"
        )
    return NOTHING


def _off(
    fit: JointFit, samples: Samples, runs: Sequence[int], settings: SignalSettings
) -> FloatArray:
    """(T, s) what all signals of some runs are off under a fit's gains; NaN where none is."""
    whole = make_signal_model(samples, fit.parameters, settings).with_planes(settings)
    there = whole.mask & np.isin(samples.run, runs)[:, None]
    return np.where(there, whole.residuals, np.nan)


def _length(off: FloatArray) -> float:
    """Typical length of vectors (T, k), some of which are not there."""
    lengths = np.linalg.norm(off[np.isfinite(off).all(axis=1)], axis=1)
    return float(np.median(lengths)) if len(lengths) else 0.0


def _tilt(off: FloatArray) -> str:
    angle = np.degrees(np.arcsin(min(1.0, _length(off))))
    return (
        f"the IMU contradicts the rest: by it the soles are tilted by {angle:.0f} deg against what "
        "the legs say on a level floor; see how it is mounted, and whether its frame is the base's"
    )


def _closure(off: FloatArray) -> str:
    place, turn = 1e3 * _length(off[:, :3]), np.degrees(_length(off[:, 3:]))
    return (
        f"the legs' joints contradict the rest: by them the soles are {place:.0f} mm and "
        f"{turn:.1f} deg off where they stand; see whether a joint's zero is off or a foot slipped"
    )


def _parity(off: FloatArray) -> str:
    force = np.nanmedian(np.abs(off))
    return (
        f"the four cells of a foot contradict each other by {force:.1f} N: see that no cell is "
        "exchanged or turned, and that all four carry the plate"
    )


def _air(off: FloatArray) -> str:
    force = np.nanmedian(np.abs(off[:, 0]))
    return (
        f"a lifted foot contradicts the rest: it reads {force:.1f} N where it should read nothing; "
        "see that nothing touches it, and that no board tares while the robot stands"
    )


_WORDS: dict[str, Callable[[FloatArray], str]] = {
    "tilt": _tilt, "closure": _closure, "parity": _parity, "air": _air,
}  # fmt: skip
