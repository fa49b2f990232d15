"""Readings that drift over the session: boards that warm up, cells that creep, a supply that sinks.

In each run alone gains and offsets follow such a drift; over all runs it has one course s(t). Two
kinds are fitted to the equations of all runs, and the one that explains them is named:
    sum_i A_i (g_i S_i (1 + a s(t)) + d_i) = w - b      gains alike, of both feet or of one
    sum_i A_i (g_i S_i + d_i + z_i s(t)) = w - b        zeros, each by its own size
The plane that four cells of a rigid sole keep to (`planes`) shows zeros whose sum stays, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.blocks import Blocks, one_after_another
from shoecal_core.screening.cells.planes import cell_forces, off_plane
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import RoughFit, Statics, solve
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET

LEAST_RUNS = 3
"""Within one run and between two, a drift looks like gains and zeros of their own."""
CONSTANTS_S = (10.0, 20.0, 40.0, 80.0, 160.0)
"""Time constants of drifts that fade; steady ones are tried, too."""
LEFT, LEAST_DROP = 0.3, 10.0
"""Of the sum of squares, what a drift leaves at most, and by how much it falls at least: supplies
that sank by 3 and 7 % leave 0.06 and 0.03, creep of 15 % 0.07, sound recordings 0.93 and more."""
GAINS_ALIKE = 1.6
"""Times what drifts of zeros leave, that one drift of all gains may: it has one size, not n."""
PLATE_LEFT, PLATE_LEAST = 0.4, 0.005
"""Of how far the cells of a rigid sole are off their plane (RMS), what a drift leaves at most; and
by how much of the weight a zero drifts then. Boards that warm up leave 0.03 to 0.07, sound
recordings 1.0."""
ONE_FOOT = 0.5
"""Of what a drift of both feet's gains leaves, that one foot's leaves at most: its course has as
many unknowns."""
LARGEST_GAIN = 0.1
"""Standard deviation of a common drift of gains, as a share."""
REFUSED_GROWTH, REFUSED_SHARE = 0.05, 0.02
"""Drifts of readings, and of a zero as a share of the weight, from which a calibration is refused:
zeros of 2 % moved the CoP of a NAO's foot by 7.6 mm, of 1 % by 3.5, where 3.4 was stated."""


@dataclass(frozen=True)
class Drift:
    """A drift over the session.

    Attributes:
        readings: by which share they grow alike; 0 where zeros drift.
        zero: by how much one zero drifts at least [N]; 0 where all readings do.
        constant: with which it fades [s]; 0: it does not.
        feet: indices of those whose cells show it by their plane.
        foot: index of the one whose readings grow; None: both.
    """

    readings: float = 0.0
    zero: float = 0.0
    constant: float = 0.0
    feet: tuple[int, ...] = ()
    foot: int | None = None


def drifting(statics: Statics, starts: Mapping[int, float]) -> Drift | None:
    """The drift that explains what runs contradict each other by; None without.

    Args:
        starts: of each run, by one clock [s].
    """
    if len(statics.parts) < LEAST_RUNS:
        return None
    time = _session_time(statics.parts, starts)
    longest = max(float(one[-1]) for one in time.values())
    constants = [0.0, *(one for one in CONSTANTS_S if one < longest / 2.0)]
    courses = [{run: _course(at, one, longest) for run, at in time.items()} for one in constants]
    fits = [_fit_zeros(statics, course) for course in courses]
    zeros = min(range(len(fits)), key=lambda at: fits[at].cost)
    none, least = statics.fit.cost, fits[zeros].cost
    explained = min(LEFT * none, none - LEAST_DROP)
    alike = _gains_alike(statics, courses)
    if alike.cost < min(explained, GAINS_ALIKE * least):
        return Drift(alike.share, constant=constants[alike.course], foot=alike.foot)
    plates = [_off_plane(statics, foot, courses) for foot in range(len(FEET))]
    feet = tuple(foot for foot, one in enumerate(plates) if one is not None)
    zero = max((one[0] for one in plates if one is not None), default=0.0)
    at = next((one[1] for one in plates if one is not None), zeros)
    if least < explained:
        vertical = np.flatnonzero(statics.shoe.vertical) - len(statics.shoe.names)
        zero = max(zero, abs(float(fits[zeros].vector[vertical].sum())))
    elif not feet:
        return None
    return Drift(zero=zero, constant=constants[at], feet=feet)


@dataclass(frozen=True)
class _GainsAlike:
    """Gains that drift alike.

    Attributes:
        cost: sum of squares that is left.
        share: by which the readings grow.
        course: index.
        foot: index of the only one; None: both.
    """

    cost: float
    share: float
    course: int
    foot: int | None


def _gains_alike(statics: Statics, courses: Sequence[Mapping[int, FloatArray]]) -> _GainsAlike:
    """The drift of gains that leaves least, by the courses (B,) of each run."""
    best = {}
    for foot in (None, *range(len(FEET))):
        fits = [_fit_gains(statics, course, foot) for course in courses]
        at = min(range(len(fits)), key=lambda index: fits[index].cost)
        best[foot] = _GainsAlike(fits[at].cost, -float(fits[at].vector[-1]), at, foot)
    one = min((best[foot] for foot in range(len(FEET))), key=lambda found: found.cost)
    # What one foot's readings grow by lets both seem to grow half as much.
    return one if one.cost < ONE_FOOT * best[None].cost else best[None]


def _fit_gains(statics: Statics, course: Mapping[int, FloatArray], foot: int | None) -> RoughFit:
    """With a drift of all gains, or those of one foot, by a course (B,) of each run."""
    n, gain = len(statics.shoe.names), statics.fit.parameters.gain
    if foot is not None:
        gain = np.where(statics.shoe.foot == foot, gain, 0.0)
    rows = {}
    for run, one in statics.robust.items():
        scaled = (one.matrix[:, :, :n] * gain).sum(axis=2)
        rows[run] = one.with_columns((scaled * course[run])[:, :, None])
    return solve(rows, np.append(statics.information, LARGEST_GAIN**-2.0))


def _fit_zeros(statics: Statics, course: Mapping[int, FloatArray]) -> RoughFit:
    """With drifts of zeros, by a course (B,) of each run."""
    n, information = len(statics.shoe.names), statics.information
    rows = {
        run: one.with_columns(one.matrix[:, :, n:] * course[run][:, None])
        for run, one in statics.robust.items()
    }
    return solve(rows, np.append(information, information[n:]))


def _off_plane(
    statics: Statics, foot: int, courses: Sequence[Mapping[int, FloatArray]]
) -> tuple[float, int] | None:
    """By how much a zero drifts at least [N], and which of the courses (B,) by run it has.

    None where the cells of a foot keep their plane, are too few, or never had one.
    """
    force = cell_forces(statics, foot)
    if not force:
        return None
    together = np.concatenate(list(force.values()))
    none, _ = off_plane(together)
    found = list[tuple[float, float]]()
    for course in courses:
        shape = np.concatenate([course[run] for run in force])
        shape = shape - shape.mean()
        size = shape @ together / (shape @ shape)
        left, across = off_plane(together - np.outer(shape, size))
        found.append((left, abs(float(across @ size)) / float(np.abs(across).sum())))
    at = int(np.argmin([left for left, _ in found]))
    left, zero = found[at]
    if left > PLATE_LEFT**2 * none or zero < PLATE_LEAST * statics.weight:
        return None
    return zero, at


def _course(time: FloatArray, constant: float, longest: float) -> FloatArray:
    """(B,) from 0 to 1 within the session, at times (B,) [s]."""
    if not constant:
        return np.asarray(time / longest)
    return np.asarray(np.expm1(-time / constant) / np.expm1(-longest / constant))


def _session_time(
    parts: Mapping[int, Blocks], starts: Mapping[int, float]
) -> dict[int, FloatArray]:
    """(B,) by run, time since the first run began [s]; none begins before the last one ended."""
    order = sorted(parts, key=lambda run: starts[run])
    at = one_after_another(
        [starts[run] for run in order], [float(parts[run].time[-1]) for run in order]
    )
    return {run: start - at[0] + parts[run].time for run, start in zip(order, at, strict=True)}


def describe_drift(found: Drift, weight: float) -> list[Finding]:
    """A drift over the session, under a weight [N]."""
    fades = f", ever slower (time constant about {found.constant:.0f} s)" if found.constant else ""
    change = f"{'grow' if found.readings > 0.0 else 'fade'} alike, by {abs(found.readings):.0%}"
    if found.foot is not None:
        text = (
            f"all readings of the {FEET[found.foot]} foot {change} from the first run on{fades}, "
            "those of the other foot do not: its cells creep, its board warms up or its supply "
            "changes; let the robot stand with the power on for some minutes before the first "
            "run, see to that foot's supply, then record again"
        )
    elif found.readings and found.constant:
        text = (
            f"all readings {change} from the first run on{fades}: cells that creep under a load "
            "that has just come on, or an amplifier that warms up; let the robot stand with the "
            "power on for some minutes before the first run, then record again"
        )
    elif found.readings:
        text = (
            f"all readings {change} from the first run to the last: the cells' supply changes "
            "against the converter's reference (a battery that empties), or all warm up; feed both "
            "from one regulator, and record again"
        )
    else:
        text = (
            f"zeros drift by {found.zero:.1f} N and more from the first run on{fades}: boards that "
            "were just switched on, or cells that get warm or wet; leave the power on for some "
            "minutes before the first run, then record again"
        )
    alike = abs(found.readings) / (1 if found.foot is None else len(FEET))  # of the whole force
    refused = alike >= REFUSED_GROWTH or found.zero >= REFUSED_SHARE * weight
    return [Finding("FAIL" if refused else "WARN", text, Fault.DRIFTING)]
