"""Screening of runs in double support by statics and the model of the body."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import typical_period
from shoecal_core.samples.lifting import TRANSIT_S, LiftedFoot, lifted
from shoecal_core.samples.stretches import JOIN_S, lasting, stretches, widened
from shoecal_core.screening.bending import Bending, bending, describe_bending
from shoecal_core.screening.blocks import Blocks, blocks
from shoecal_core.screening.changed_gains import changed_gains, describe_changed_gains
from shoecal_core.screening.closure import FootMotion, Slipped, describe_slips, feet, slips
from shoecal_core.screening.disturbed import disturbed
from shoecal_core.screening.drifting import describe_drift, drifting
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.hanging import both_hang, without
from shoecal_core.screening.hum import describe_hum, find_hum
from shoecal_core.screening.leaking import describe_leaking, leaking
from shoecal_core.screening.noise import noise
from shoecal_core.screening.pulled import Pull, describe_pulls, describe_wavering, pulls, wavering
from shoecal_core.screening.quasi_static import too_fast
from shoecal_core.screening.result import LeftOut, Screening, describe_left_out
from shoecal_core.screening.rough_fit import Statics, reweighed, solve
from shoecal_core.screening.saturated import (
    AT_END_STDS,
    Saturated,
    at_ends,
    describe_saturated,
    flat,
    saturated,
    within_range,
)
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.sideways import describe_sideways, sideways_fault, sideways_pulls
from shoecal_core.screening.spikes import find_jumps
from shoecal_core.screening.turned_frames import describe_turned_frames, turned_frames
from shoecal_core.screening.unexplained import describe_unexplained, unexplained
from shoecal_core.screening.verdict import Finding
from shoecal_core.screening.wandering import describe_wandering, wandering
from shoecal_core.screening.weights import describe_weights, wrong_weights
from shoecal_core.screening.wiring import check_wiring, describe_wiring
from shoecal_core.screening.zeros import describe_zeros, moved_zeros
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, foot_wrenches

SPOILS_SHARE = 0.2
"""Of the time, that a channel is at an end at least, before it spoils what other faults show: those
that are there for less are looked for when runs under another weight are known."""
MARGIN_S = 0.15
"""Also left out around what moved, pushed or lifted the robot: it still sways."""
HIT_MARGIN_S = 0.03
"""The same around a hit that is over at once."""
LIFT_S = 0.8
"""A foot that is off the floor for longer, margins included, is in the air: that is no step."""
PULL_MARGIN_S = 1.0
"""Left out before and after a pull, while it begins and ends."""
SLIP_MARGIN_S = 0.5
"""Left out before a slip: when it began is known no better."""
LEAST_SHARE = 0.4
"""A run of which less is usable is left out."""
FREE_SHARE = 0.2
"""A foot that was lifted on purpose and carries more of the weight still touches something; the
rough fit knows a foot's share no better."""
CALM_S = 0.2
"""Loads are medians of so long a time: no noise lifts a foot or puts it down."""
LEAST_JUMP_STDS = 1.0
"""Smaller jumps do no harm, in the settings' standard deviations of the force."""


def screen_standing(
    found: Screening,
    aligned: Mapping[int, Aligned],
    lifting: Mapping[int, LiftedFoot | None],
    fast: Collection[int],
    starts: Mapping[int, float],
    shoe: Shoe,
    weight: float,
    settings: CalibrationSettings,
) -> Screening:
    """What was found so far, and what is found in these runs.

    Args:
        aligned: runs in double support, by number.
        starts: of each of them, by one clock [s].
        lifting: of each of them, the foot that it lifts on purpose.
        fast: those of a fast motion, which disturbs them without any fault.
        weight: of robot and shoes [N].
    """
    hanging = both_hang(aligned, shoe, weight, settings)
    aloft = {run: widened(one, aligned[run].time, TRANSIT_S) for run, one in hanging.items()}
    parts = {
        run: blocks(within_range(shoe, without(one, hanging.get(run))), shoe)
        for run, one in aligned.items()
    }
    statics = Statics.of(shoe, parts, weight, settings)
    watched = {run for run, lift in lifting.items() if lift is None} - {*fast, *hanging}
    at_end = flat(shoe, parts)
    early = _flat(statics, at_end)
    bent = bending(statics)
    if not found.adding(early).fails:  # else gains and cables seem to be wrong
        early = _varying(statics, watched, bent)
    found = found.adding(early)
    if not found.fails and len(aligned) > 1:
        height = float(np.median([np.median(one.states.com[:, 0, 2]) for one in aligned.values()]))
        found = found.adding(_electrical(statics, height, starts))
    steady = {run: aligned[run] for run, lift in lifting.items() if lift is None}
    if not found.fails:
        slow = {run: one for run, one in steady.items() if run not in fast}
        found = found.adding(describe_sideways(sideways_fault(shoe, slow, weight)))
    if found.fails:
        return found
    pushed = sideways_pulls(shoe, steady, weight) + pulls(statics, watched)
    pulled = {one.run: one for one in pushed}
    sound = statics.without(pulled)
    wrong = wrong_weights(sound)
    # Neither a pull nor a load is let in, which bend the gains of all runs; with gains of a single
    # run, a pull on the other one looks like a cell at its end.
    unloaded = sound.without({one.run for one in wrong})
    fitted = unloaded if unloaded.parts else statics
    checked = sound if any(one.undecided for one in pulled.values()) else statics
    ended = _ended(fitted, checked, at_end)
    found = found.adding(describe_saturated(shoe, ended))
    if found.fails:
        return found
    found = found.adding(describe_pulls(list(pulled.values())) + describe_weights(wrong, weight))
    if found.fails:
        return found
    found = found.adding(_minor(fitted, watched, bent))
    fitting = [run for run in parts if run in unloaded.parts or run in pulled]
    watch = _Watch(shoe, fitted.fit.parameters, weight, settings, ended)
    found = replace(found, load={run: watch.load(one) for run, one in aligned.items()})
    moments = {
        run: watch.moments(aligned[run], parts[run], lifting[run], aloft.get(run), pulled.get(run))
        for run in fitting
    }
    found = replace(found, hanging={run: one for run, one in hanging.items() if run in fitting})
    slipped = _slipped(moments)
    found = found.adding(describe_slips(slipped))
    for run, one in aligned.items():
        if run in moments:
            slip = slipped.get(run)
            found = _leaving_out(found, run, one, moments[run], slip, shoe, fast=run in fast)
        else:
            found = _leaving_out_all(found, run, one)
    return found


def _ended(fitted: Statics, checked: Statics, at_end: Mapping[int, BoolArray]) -> list[Saturated]:
    """Channels with an end in the runs that are checked, by gains of those that are fitted.

    Args:
        at_end: (B,) blocks of each run that say nothing of the gains, see `flat`.
    """
    going = {
        run: one.part(~at_end[run]) for run, one in fitted.rows.items() if not at_end[run].all()
    }
    fit = solve(reweighed(going, fitted.information), fitted.information)
    missing = {run: checked.force_error(run, fit.vector) for run in checked.parts}
    return saturated(checked.parts, missing, fit.parameters, checked.settings)


def _flat(statics: Statics, at_end: Mapping[int, BoolArray]) -> list[Finding]:
    """Channels that have an end, where one stays there while its neighbours go on."""
    if not any(one.any() for one in at_end.values()):
        return []
    found = _ended(statics, statics, at_end)
    return describe_saturated(statics.shoe, [one for one in found if one.share > SPOILS_SHARE])


def _varying(statics: Statics, watched: Collection[int], bent: Bending | None) -> list[Finding]:
    """What lets the vertical force vary by much in most runs: bent cells, cables, or a hand."""
    wavers = wavering(statics, watched)
    if wavers is None:
        return []
    if bent is not None:
        return describe_bending(statics.shoe, bent, refused=True)
    wiring = check_wiring(statics)
    return describe_wiring(statics.shoe, wiring) if wiring.clear else describe_wavering(wavers)


def _minor(statics: Statics, watched: Collection[int], bent: Bending | None) -> list[Finding]:
    """What a calibration copes with; left to the last, as all else is likelier."""
    known = describe_hum(find_hum(statics, watched)) + describe_bending(statics.shoe, bent)
    return known or describe_unexplained(unexplained(statics))


def _electrical(statics: Statics, height: float, starts: Mapping[int, float]) -> list[Finding]:
    """The first fault of zeros, gains, cables and converter that is found.

    Their order is a decision: each of them looks like some of those that come after it.

    Args:
        height: of the CoM over the floor [m].
        starts: of each run, by one clock [s].
    """
    shoe = statics.shoe
    moved = moved_zeros(statics, height)
    if moved is not None:
        return describe_zeros(shoe, moved, statics.weight)
    drift, wanders = drifting(statics, starts), wandering(statics)
    # One cell that wanders makes zeros drift, at its foot alone.
    if drift is not None and (wanders is None or drift.readings or drift.feet[1:]):
        return describe_drift(drift, statics.weight)
    if wanders is not None:
        return describe_wandering(shoe, wanders)
    changed = changed_gains(statics)
    if changed is not None:
        return describe_changed_gains(shoe, changed)
    return (
        describe_wiring(shoe, check_wiring(statics))
        or describe_leaking(shoe, leaking(statics))
        or describe_turned_frames(turned_frames(statics))
    )


def _slipped(moments: Mapping[int, _Moments]) -> dict[int, Slipped]:
    """The first slip of each run; a foot that was lifted may stand elsewhere afterwards."""
    calm = {
        (run, part): feet
        for run, one in moments.items()
        for part, feet in enumerate(one.calm)
        if len(feet.time) > 1
    }
    found: dict[int, Slipped] = {}
    for (run, _), slip in sorted(slips(calm).items()):
        found.setdefault(run, slip)
    return found


@dataclass(frozen=True)
class _Moments:
    """What happened in one run, and when.

    Attributes:
        marked: (T,) by fault, the gravest first.
        spikes: (T, n).
        air: (T,) the foot that was lifted on purpose hangs free.
        off_floor: name of the foot that carries less while one is lifted; empty where none is.
        calm: samples while both feet stand, their readings without jumps; before, between and
            after the times that a foot was in the air on purpose.
    """

    marked: Mapping[Fault, BoolArray]
    spikes: BoolArray
    air: BoolArray
    off_floor: str
    calm: tuple[FootMotion, ...]


@dataclass(frozen=True)
class _Watch:
    """Finds moments that break the assumptions."""

    shoe: Shoe
    parameters: ChannelParameters
    weight: float
    settings: CalibrationSettings
    ended: Sequence[Saturated]

    def moments(
        self,
        aligned: Aligned,
        part: Blocks,
        lifting: LiftedFoot | None,
        aloft: BoolArray | None,
        pull: Pull | None,
    ) -> _Moments:
        """What happened in a run; `aloft` (T,): the whole robot is lifted, or on its way."""
        time, settings = aligned.time, self.settings
        if aloft is None:
            aloft = np.zeros(len(time), dtype=bool)
        trembling = noise(aligned.readings)
        least = LEAST_JUMP_STDS * settings.force_std_n
        jumps = find_jumps(self.shoe, aligned.readings, trembling, self.parameters.gain, least)
        wrench = self.parameters.outputs(jumps.calm) @ part.columns + part.base
        place = cop(wrench, MINIMUM_FORCE) - aligned.states.cop[:, 0]
        nowhere = ~np.isfinite(place).all(axis=1)
        place[nowhere] = 0.0
        pushed = disturbed(time, wrench[:, 0] - self.weight, place, settings) | nowhere
        up = widened(lifted(aligned.states), time, MARGIN_S)
        grounded = ~lasting(up, time, LIFT_S) & ~aloft
        meant = air = np.zeros_like(up)
        calm = [feet(aligned, jumps.calm, grounded)]
        if lifting is not None and self._hangs(lifting, jumps.calm):
            meant, air = lifting.air | lifting.moving, lifting.air
            calm = [
                feet(aligned, jumps.calm, stretch & grounded)
                for stretch in lifting.stretches()
                if not lifting.air[stretch].any()
            ]
        marked = {
            Fault.SATURATED: self._at_end(aligned.readings, trembling),
            Fault.HANGING: aloft,
            Fault.PULLED: _pulled(pull, time),
            Fault.LIFTED: up & ~meant,
            Fault.LIFTING: meant & ~air,
            Fault.TOO_FAST: widened(too_fast(aligned, settings), time, MARGIN_S),
            Fault.DISTURBED: widened(pushed, time, MARGIN_S)
            | widened(jumps.hits, time, HIT_MARGIN_S),
        }
        return _Moments(marked, jumps.spikes, air, self._off_floor(up, jumps.calm), tuple(calm))

    def load(self, aligned: Aligned) -> FloatArray:
        """(T, 2) each foot's share of the weight."""
        share = self._carried(aligned.readings) / self.weight
        window = max(1, round(CALM_S / typical_period(aligned.time)))
        calm: FloatArray = median_filter(share, (window, 1), mode="nearest")
        return calm

    def _carried(self, readings: FloatArray) -> FloatArray:
        """(T, 2) vertical force on each foot, for readings (T, n) [N]."""
        return foot_wrenches(self.shoe, self.parameters.outputs(readings))[..., 0]

    def _off_floor(self, up: BoolArray, readings: FloatArray) -> str:
        """The foot that carries less at these samples (T,) of readings (T, n)."""
        if not up.any():
            return ""
        return FEET[int(np.argmin(np.median(self._carried(readings[up]), axis=0)))]

    def _hangs(self, lifting: LiftedFoot, readings: FloatArray) -> bool:
        """Whether the foot that was lifted carries nothing meanwhile."""
        if not lifting.air.any():
            return False
        carried = self._carried(readings[lifting.air])[:, lifting.foot]
        return abs(float(np.median(carried))) < FREE_SHARE * self.weight

    def _at_end(self, readings: FloatArray, trembling: FloatArray) -> BoolArray:
        there = at_ends(self.shoe, readings).any(axis=1)
        for one in self.ended:
            off = np.abs(readings[:, one.channel] - one.level)
            there |= off <= AT_END_STDS * trembling[one.channel]
        return np.asarray(there)


def _pulled(pull: Pull | None, time: FloatArray) -> BoolArray:
    """(T,) samples at which a force from outside acts, and while it begins and ends."""
    marked = np.zeros(len(time), dtype=bool)
    for start, end in pull.stretches if pull is not None else ():
        marked |= (time >= start - PULL_MARGIN_S) & (time <= end + PULL_MARGIN_S)
    return marked


def _leaving_out(
    found: Screening,
    run: int,
    aligned: Aligned,
    moments: _Moments,
    slip: Slipped | None,
    shoe: Shoe,
    *,
    fast: bool,
) -> Screening:
    """Leave out what was marked, and what came after a slip; gears that strike are only counted
    in a fast motion.
    """
    time = aligned.time
    before = time < (np.inf if slip is None else slip.time - SLIP_MARGIN_S)
    kept, lost = np.ones(len(time), dtype=bool), list[LeftOut]()

    def leave(fault: Fault, marked: BoolArray, *channels: str) -> None:
        fresh = marked & kept
        kept[marked] = False
        if fresh.any():
            foot = moments.off_floor if fault is Fault.LIFTED else ""
            lost.append(_lost(found, run, fault, fresh, time, channels, foot))

    for fault, marked in moments.marked.items():
        leave(fault, marked)
    for name, marked in zip(shoe.names, moments.spikes.T, strict=True):
        leave(Fault.SPIKE, marked, name)
    leave(Fault.SLIPPED, ~before)
    if kept.sum() < LEAST_SHARE * (found.samples[run] - moments.marked[Fault.HANGING].sum()):
        lost.append(_lost(found, run, Fault.TOO_LITTLE, kept, time))
        kept = np.zeros_like(kept)
    notable = [one for one in lost if not (fast and one.fault is Fault.DISTURBED)]
    off = (Fault.LIFTED, Fault.LIFTING, Fault.HANGING)
    standing = before & ~np.any([moments.marked[fault] for fault in off], axis=0)
    return replace(
        found.adding(describe_left_out(notable)),
        left_out=(*found.left_out, *lost),
        kept={**found.kept, run: kept},
        standing={**found.standing, run: standing},
        air={**found.air, run: moments.air},
    )


def _leaving_out_all(found: Screening, run: int, aligned: Aligned) -> Screening:
    """Leave out a run under another weight."""
    everything = np.ones(len(aligned.time), dtype=bool)
    lost = _lost(found, run, Fault.WRONG_WEIGHT, everything, aligned.time)
    return replace(
        found,
        left_out=(*found.left_out, lost),
        kept={**found.kept, run: ~everything},
        standing={**found.standing, run: everything},
    )


def _lost(
    found: Screening,
    run: int,
    fault: Fault,
    marked: BoolArray,
    time: FloatArray,
    channels: tuple[str, ...] = (),
    foot: str = "",
) -> LeftOut:
    count = int(marked.sum())
    times = stretches(marked, time, JOIN_S)
    return LeftOut(run, fault, count, count / found.samples[run], times, channels, foot)
