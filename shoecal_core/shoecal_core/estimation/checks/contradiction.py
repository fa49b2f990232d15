"""Which signals contradict the others, where a joint fit does not settle.

Each family of signals, and each run, is left out in turn. Where the rest can be fitted, its fit
predicts what was left out, with a covariance C by noise, form error, tolerances and what the rest
leaves unknown. The size of a contradiction r of m values is the root of r' C^-1 r / m: in
standard deviations, and so comparable over families. The largest is named; one that tolerances
explain is none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources import body
from shoecal_core.error_sources.as_built import of_body, of_shoes
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import COP, FAMILIES
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import JointFit, UnsettledError, sample_std_of
from shoecal_core.samples.samples import Samples
from shoecal_core.screening.pose.imu import WRONG_RAD

Solve = Callable[[Sequence[int], frozenset[str]], JointFit]
"""Fits some runs without some families of signals, or raises an `UnsettledError`."""
LEAST_RUNS = 3
"""Runs from which one can be left out."""
LEAST_SIZE = 3.0
"""Standard deviations from which a contradiction is named: tolerances explain smaller ones."""
NOTHING = (
    "no single family of signals (IMU, legs' joints, four cells of a foot, lifted foot) and no "
    "single run contradicts the rest beyond its tolerance: run `shoecal check SESSION`, and see "
    "that robot and shoe files are those of what was recorded"
)


def contradiction(
    solve: Solve,
    samples: Samples,
    train: Sequence[int],
    settings: SignalSettings,
    tolerances: Tolerances,
) -> str:
    """What contradicts the rest most, by how much, and what to do, in words.

    Args:
        solve: the fit that did not settle.
        samples: of all runs. train: those that were fitted.
        settings: of the signals.
        tolerances: of the fit.
    """
    trained = np.isin(samples.run, train)
    found = []
    for family, part in FAMILIES.items():
        with suppress(UnsettledError):
            rest = _Rest.of(solve(train, frozenset((family,))), settings, tolerances)
            there = np.zeros_like(rest.whole.mask)
            there[:, part] = trained[:, None]
            if (there & rest.whole.mask).any():
                found.append(_of_family(family, rest, there, part))
    for run in train if len(train) >= LEAST_RUNS and not _named(found) else ():
        with suppress(UnsettledError):
            others = [one for one in train if one != run]
            rest = _Rest.of(solve(others, frozenset()), settings, tolerances)
            found.append(_of_run(run, rest))
    return max(_named(found), key=lambda one: one.size).text if _named(found) else NOTHING


@dataclass(frozen=True)
class _Contradiction:
    """One that may be named: its size in standard deviations, and in words."""

    size: float
    text: str


def _named(found: Sequence[_Contradiction]) -> list[_Contradiction]:
    """Those that tolerances do not explain."""
    return [one for one in found if one.size >= LEAST_SIZE]


@dataclass(frozen=True)
class _Rest:
    """The fit of the rest, and all signals under its gains.

    Attributes:
        fit: without what it is compared with.
        whole: all signals.
        columns: (u, T, s) what a unit of each of the fit's unknowns adds to them.
        sample_std: (s,) of the signals.
    """

    fit: JointFit
    whole: SignalModel
    columns: FloatArray
    sample_std: FloatArray

    @classmethod
    def of(cls, fit: JointFit, settings: SignalSettings, tolerances: Tolerances) -> _Rest:
        """About the gains that the fit's last step was linear about."""
        whole = replace(fit.system.signal_model, without=frozenset())
        deviations = (*of_body(whole, tolerances), *of_shoes(whole, tolerances))
        own = 2 * len(whole.parameters.gain)
        columns = np.concatenate(
            (
                whole.baseline[:own],
                fit.system.columns[own : own + 1],  # of the time offset: in the CoP alone
                [one.column for one in deviations],
                whole.baseline[own:],
            )
        )
        return cls(fit, whole, columns, sample_std_of(whole, settings))

    @cached_property
    def left(self) -> FloatArray:
        """(T, s) what the fit leaves of all signals; NaN where there is none."""
        left = self.whole.residuals - np.tensordot(self.fit.system.solution(), self.columns, 1)
        return np.where(self.whole.mask, left, np.nan)

    def size(self, looked_at: BoolArray) -> float:
        """Of some values (T, s), in standard deviations of what the fit predicts of them."""
        there = looked_at & self.whole.mask
        scale = 1.0 / np.broadcast_to(self.sample_std, there.shape)[there]
        surprise = self.fit.system.surprise(
            self.columns[:, there] * scale, self.whole.residuals[there] * scale
        )
        return float(np.sqrt(max(surprise, 0.0) / there.sum()))


def _of_family(family: str, rest: _Rest, there: BoolArray, part: slice) -> _Contradiction:
    rows: BoolArray = np.any(there[:, part], axis=1)
    size = rest.size(there)
    if family == "tilt":
        angle = _angle(rest, rows)
        # The fit leaves open how an IMU is mounted, but none is mounted so far off its frame.
        size = max(size, LEAST_SIZE * angle / WRONG_RAD)
        seen, cure = _tilt(angle)
    else:
        seen, cure = _WORDS[family](rest.left[rows, part])
    return _Contradiction(size, f"{seen}{_times(size)}{cure}")


def _of_run(run: int, rest: _Rest) -> _Contradiction:
    rows = rest.whole.samples.run == run
    size = rest.size(np.broadcast_to(rows[:, None], rest.whole.mask.shape))
    return _Contradiction(
        size,
        f"run {run} contradicts the others: its CoP is {1e3 * _length(rest.left[rows, COP]):.0f} "
        f"mm off the model that they fit{_times(size)}; leave it out (--train), or see what was "
        "different in it",
    )


def _times(size: float) -> str:
    return f" ({size:.0f} times what is expected)"


def _length(off: FloatArray) -> float:
    """Typical length of vectors (T, k), some of which are not there."""
    lengths = np.linalg.norm(off[np.isfinite(off).all(axis=1)], axis=1)
    return float(np.median(lengths)) if len(lengths) else 0.0


def _angle(rest: _Rest, rows: BoolArray) -> float:
    """Typical angle between upwards by the IMU and by level soles, of samples (T,) [rad]."""
    samples = rest.whole.samples
    up = body.up_in_sole(samples.states, samples.frame, samples.up)[rows]
    across = np.linalg.norm(up[:, :2], axis=1)
    return float(np.nanmedian(np.arctan2(across, up[:, 2])))


def _closure(off: FloatArray) -> tuple[str, str]:
    place, turn = 1e3 * _length(off[:, :3]), np.degrees(_length(off[:, 3:]))
    seen = (
        f"the legs' joints contradict the rest: by them the soles are {place:.0f} mm and "
        f"{turn:.1f} deg off where they stand"
    )
    return seen, "; see whether a joint's zero is off or a foot slipped"


def _parity(off: FloatArray) -> tuple[str, str]:
    # A constant is left open: zeros differ.
    force = np.nanmedian(np.abs(off - np.nanmean(off, axis=0)))
    return (
        f"the four cells of a foot contradict each other by {force:.1f} N",
        ": see that no cell is exchanged or turned, and that all four carry the plate",
    )


def _air(off: FloatArray) -> tuple[str, str]:
    force = np.nanmedian(np.abs(off[:, 0]))
    return (
        f"a lifted foot contradicts the rest: it reads {force:.1f} N where it should read nothing",
        "; see that nothing touches it, and that no board tares while the robot stands",
    )


def _tilt(angle: float) -> tuple[str, str]:
    seen = (
        f"the IMU contradicts the rest: by it the soles are tilted by {np.degrees(angle):.0f} deg "
        "against what the legs say on a level floor"
    )
    return seen, "; see how it is mounted, and whether its frame is the base's"


_WORDS: dict[str, Callable[[FloatArray], tuple[str, str]]] = {
    "closure": _closure, "parity": _parity, "air": _air,
}  # fmt: skip
"""What is seen of a family, and its cure, by what the fit leaves (T, k)."""
