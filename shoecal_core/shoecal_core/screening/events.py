"""What happened in a run in double support that a fit leaves out, and when."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import typical_period
from shoecal_core.samples.lifting import LiftedFoot, lifted
from shoecal_core.samples.stretches import JOIN_S, lasting, stretches, widened
from shoecal_core.screening.blocks import Blocks
from shoecal_core.screening.cells.saturated import AT_END_STDS, Saturated, at_ends
from shoecal_core.screening.cells.spikes import find_jumps
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.disturbed import disturbed
from shoecal_core.screening.loads.pulled import Pull
from shoecal_core.screening.noise import noise
from shoecal_core.screening.pose.closure import FootMotion, Slipped, feet, slips
from shoecal_core.screening.quasi_static import too_fast
from shoecal_core.screening.result import LeftOut, Screening, describe_left_out
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, foot_wrenches

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


def first_slips(events: Mapping[int, Events]) -> dict[int, Slipped]:
    """The first slip of each run; a foot that was lifted may stand elsewhere afterwards."""
    calm = {
        (run, part): feet
        for run, one in events.items()
        for part, feet in enumerate(one.calm)
        if len(feet.time) > 1
    }
    found: dict[int, Slipped] = {}
    for (run, _), slip in sorted(slips(calm).items()):
        found.setdefault(run, slip)
    return found


@dataclass(frozen=True)
class Events:
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
class Watch:
    """Finds events that break the assumptions."""

    shoe: Shoe
    parameters: ChannelParameters
    weight: float
    settings: CalibrationSettings
    ended: Sequence[Saturated]

    def events(
        self,
        aligned: Aligned,
        part: Blocks,
        lifting: LiftedFoot | None,
        aloft: BoolArray | None,
        pull: Pull | None,
    ) -> Events:
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
        return Events(marked, jumps.spikes, air, self._off_floor(up, jumps.calm), tuple(calm))

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


def leave_out_marked(
    found: Screening,
    run: int,
    aligned: Aligned,
    events: Events,
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
            foot = events.off_floor if fault is Fault.LIFTED else ""
            lost.append(_lost(found, run, fault, fresh, time, channels, foot))

    for fault, marked in events.marked.items():
        leave(fault, marked)
    for name, marked in zip(shoe.names, events.spikes.T, strict=True):
        leave(Fault.SPIKE, marked, name)
    leave(Fault.SLIPPED, ~before)
    if kept.sum() < LEAST_SHARE * (found.samples[run] - events.marked[Fault.HANGING].sum()):
        lost.append(_lost(found, run, Fault.TOO_LITTLE, kept, time))
        kept = np.zeros_like(kept)
    notable = [one for one in lost if not (fast and one.fault is Fault.DISTURBED)]
    off = (Fault.LIFTED, Fault.LIFTING, Fault.HANGING)
    standing = before & ~np.any([events.marked[fault] for fault in off], axis=0)
    return replace(
        found.adding(describe_left_out(notable)),
        left_out=(*found.left_out, *lost),
        kept={**found.kept, run: kept},
        standing={**found.standing, run: standing},
        air={**found.air, run: events.air},
    )


def leave_out_run(
    found: Screening, run: int, aligned: Aligned, fault: Fault = Fault.WRONG_WEIGHT
) -> Screening:
    """Leave out a whole run."""
    everything = np.ones(len(aligned.time), dtype=bool)
    lost = _lost(found, run, fault, everything, aligned.time)
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
