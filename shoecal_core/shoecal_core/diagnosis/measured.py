"""What needs no fit: zeros that feet in the air show, and the weight by data sheets.

Screening finds both as well. All else is looked for as if every run had the mean zeros of the
training runs, and the robot that weight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.diagnosis.result import Cause, Shrink, Size
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import shrink
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.base import ALL
from shoecal_core.error_sources.effects import places
from shoecal_core.estimation.session_data import SessionData
from shoecal_core.estimation.walking_fit import common_zeros, zero_shifts
from shoecal_core.estimation.weight import Weighed
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.zeros import NORMAL_95, Zero, data_sheet
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import ChannelParameters

SURE_STDS = 4.0
"""By which a zero has to be off: a session has many of them."""


@dataclass(frozen=True)
class Moved:
    """A foot that shows another zero in one run than in the training runs.

    Attributes:
        run, foot: which.
        offset, std: of each vertical channel [N].
    """

    run: int
    foot: int
    offset: float
    std: float


@dataclass(frozen=True)
class MeasuredBefore:
    """What was found so.

    Attributes:
        moved: zeros, the farthest first.
        zeros: of all runs; empty where none moved.
        train: runs whose zeros are taken.
        heavier: the robot with the weight by data sheets; None where its file's may be right.
        weighed: that weight.
    """

    moved: tuple[Moved, ...] = ()
    zeros: tuple[Zero, ...] = ()
    train: tuple[int, ...] = ()
    heavier: Robot | None = None
    weighed: Weighed | None = None

    def __bool__(self) -> bool:
        return bool(self.moved) or self.heavier is not None

    def corrected(self, samples: Samples) -> Samples:
        """The session with the mean zeros in every run, and with that weight."""
        samples = at_zeros(samples, self.zeros, self.train)
        if self.heavier is None:
            return samples
        force = samples.force * (self.heavier.mass / samples.robot.mass)
        return replace(samples, robot=self.heavier, force=force)

    def causes(
        self, before: Workspace, corrected: Workspace, settings: DiagnosisSettings
    ) -> list[Cause]:
        """What it is, by what is left of the session as it came and as corrected."""
        gone = shrink(corrected, before.explained(None)[0], corrected.explained(None)[0])
        found = [_zero_cause(one, gone) for one in self.moved]
        if self.heavier is not None:
            found.append(self._weight_cause(before.signal_model.samples.robot.mass, gone, settings))
        return found

    def _weight_cause(self, mass: float, gone: Shrink, settings: DiagnosisSettings) -> Cause:
        """A common error of all data sheets would look the same.

        Args:
            mass: as the robot file has it [kg].
        """
        assert self.weighed is not None
        low, high = self.weighed.ci95
        off = self.weighed.kg - mass
        return Cause(
            effect="total_mass",
            group="body",
            location=(ALL,),
            probability=_surely(off / mass / settings.nominal_gain_std),
            size={"mass": Size(off, "kg", (low - mass, high - mass))},
            run=None,
            shrink=gone,
            hidden_cop_mm=0.0,
        )


def measure(
    data: SessionData,
    samples: Samples,
    zeros: tuple[Zero, ...],
    train: Sequence[int],
    fitted: ChannelParameters,
    settings: DiagnosisSettings,
    *,
    weighs: bool,
) -> MeasuredBefore:
    """Look for zeros that moved, and for another weight than the robot file's.

    Args:
        data: of the session.
        samples: of it. zeros: of its runs.
        train: runs.
        fitted: gains of channels without data sheets.
        weighs: whether the weight may be wrong.
    """
    found = _moved(samples, zeros, train, fitted, settings)
    taken = zeros if found else ()
    weighed, mass = data.weighed, samples.robot.mass
    if weighed is None or not weighs or weighed.ci95[0] <= mass <= weighed.ci95[1]:
        return MeasuredBefore(tuple(found), taken, tuple(train))
    if abs(weighed.kg - mass) <= mass * settings.material_share:
        return MeasuredBefore(tuple(found), taken, tuple(train))
    robot = load_robot(data.session.robot_yaml, data.shoe, weight_kg=weighed.kg)
    return MeasuredBefore(tuple(found), taken, tuple(train), robot, weighed)


def at_zeros(samples: Samples, zeros: Sequence[Zero], train: Sequence[int]) -> Samples:
    """Readings as if every run whose feet were in the air had the mean zeros of the training runs.

    A foot that is in the air in no training run is left as it is.
    """
    shift = zero_shifts(samples.shoe, zeros, common_zeros(samples.shoe, zeros, train))
    nothing = np.zeros(len(samples.shoe.names))
    readings = samples.readings.copy()
    for run, change in shift.items():
        readings[samples.run == run] += change
    tracks = tuple(
        replace(track, readings=track.readings + shift.get(track.run, nothing))
        for track in samples.tracks
    )
    return replace(samples, tracks=tracks, readings=readings)


def _moved(
    samples: Samples,
    zeros: Sequence[Zero],
    train: Sequence[int],
    fitted: ChannelParameters,
    settings: DiagnosisSettings,
) -> list[Moved]:
    """Zeros that differ from the mean of the training runs, surely and enough to matter."""
    shoe, found = samples.shoe, []
    least = samples.robot.weight * settings.material_share
    for foot in range(len(FEET)):
        law = data_sheet(shoe, foot) or fitted
        shown = {zero.run: zero.force(shoe, law) for zero in zeros if zero.foot == foot}
        base = [shown[run] for run in train if run in shown]
        if not base or len(shown) < 2:
            continue
        mean = float(np.mean([force for force, _ in base]))
        spread = float(np.sqrt(np.mean([std**2 for _, std in base]) / len(base)))
        cells = np.count_nonzero(shoe.foot[places.vertical(shoe)] == foot)
        for run, (force, std) in shown.items():
            off, unsure = force - mean, math.hypot(std, spread)
            if abs(off) > max(SURE_STDS * unsure, least):
                found.append(Moved(run, foot, float(off / cells), float(unsure / cells)))
    return sorted(found, key=lambda one: -abs(one.offset))


def _zero_cause(one: Moved, gone: Shrink) -> Cause:
    half = NORMAL_95 * one.std
    return Cause(
        effect="zero_offset",
        group="load_cell",
        location=(FEET[one.foot],),
        probability=_surely(one.offset / one.std),
        size={"offset": Size(one.offset, "N", (one.offset - half, one.offset + half))},
        run=one.run,
        shrink=gone,
        hidden_cop_mm=0.0,
    )


def _surely(stds: float) -> float:
    """Probability that a normal number is not as far off as this many standard deviations."""
    return math.erf(abs(stds) / math.sqrt(2.0))
