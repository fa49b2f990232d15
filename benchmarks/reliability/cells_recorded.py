"""Cells that are broken while a calibration is recorded: is one ever applied that they spoilt?"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fault_cables import saturated, spikes, stuck, with_values
from fault_draws import Draw, Expected, FaultySession, Injected, NoFaultError
from population import Member, different_robots, nao, sessions
from shoecal_core.calibration.evaluate import errors, measured_series, truth_series
from shoecal_core.calibration.pipeline import calibrate_session, load_data
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.sensing.sensing import Sensing

FloatArray = NDArray[np.float64]

ROBOTS = 3
"""Sessions of the population, of that many robots."""
WORSE_M = 1e-3
"""By so much worse on the truth than without the fault a calibration is spoilt."""
ATTEMPTS = 30


@dataclass(frozen=True)
class CellDraw(Draw):
    """A draw of a chosen cell.

    Attributes:
        chosen: index of the cell.
    """

    chosen: int = 0

    def cell(self) -> int:
        return self.chosen


def off(draw: Draw) -> Injected:
    """No reading from some moment on; or one number all the time."""
    cell, rng = draw.cell(), draw.rng
    if rng.integers(2):
        level = float(rng.choice([0.0, 5.0, -5.0]))
        return _of(draw, cell, lambda values: np.full_like(values, level))
    share = float(rng.uniform(0.0, 0.7))

    def gone(values: FloatArray) -> FloatArray:
        return np.where(np.arange(len(values)) < share * len(values), values, np.nan)

    return _of(draw, cell, gone)


def not_a_number(draw: Draw) -> Injected:
    """Readings here and there that are none."""
    rng = draw.rng
    share = float(rng.uniform(0.01, 0.5))
    return _of(
        draw, draw.cell(), lambda values: np.where(rng.random(len(values)) < share, np.nan, values)
    )


def slow(draw: Draw) -> Injected:
    """Follows with a time constant of 0.2 to 2 s."""
    constant_s = float(draw.rng.uniform(0.2, 2.0))

    def late(values: FloatArray) -> FloatArray:
        share, followed = 1.0 - np.exp(-0.01 / constant_s), values.copy()
        for index in range(1, len(values)):
            followed[index] = followed[index - 1] + share * (values[index] - followed[index - 1])
        return followed

    return _of(draw, draw.cell(), late)


def swapped(draw: Draw) -> Injected:
    """At another cell's place, of either foot."""
    cell = draw.cell()
    other = int(draw.rng.choice([one for one in range(len(draw.shoe.names)) if one != cell]))
    order = np.arange(len(draw.shoe.names))
    order[[cell, other]] = other, cell
    return Injected(
        {
            number: with_values(run, run.readings.value[:, order])
            for number, run in draw.runs.items()
        },
        Expected(()),
    )


RECORDED: Mapping[str, Callable[[Draw], Injected]] = {
    "off": off,
    "stuck": stuck,
    "saturated": saturated,
    "NaN": not_a_number,
    "spikes": spikes,
    "slow": slow,
    "swapped": swapped,
}


@dataclass(frozen=True)
class Applied:
    """What came of a calibration from spoilt recordings.

    Attributes:
        applied: whether it would be put in force.
        told: the verdict, or why there is none.
        worse: CoP error against the simulated truth over that without the fault [m]; NaN where
            nothing would be applied.
    """

    applied: bool
    told: str
    worse: float = float("nan")

    @property
    def spoilt(self) -> bool:
        """Whether a spoilt one would be applied."""
        return self.applied and not self.worse < WORSE_M


def calibrate_spoilt(fault: str, cell: int, number: int) -> Applied:
    """Calibrate from a session of which one cell was broken."""
    members = different_robots(ROBOTS)
    for _ in sessions(members):  # made where they do not stand yet
        pass
    member = members[number % ROBOTS]
    draw: Draw = CellDraw(f"cells {fault}", number, member, nao()[1], chosen=cell)
    for _ in range(ATTEMPTS):
        try:
            injected = RECORDED[fault](draw)
            break
        except NoFaultError:
            draw = draw.again()
    else:
        raise ShoecalError(f"{fault} of cell {cell}: no fault in {ATTEMPTS} attempts")
    session = FaultySession.of(member.folder, draw.all_runs(injected))
    try:
        outcome = calibrate_session(session, member.train, member.test)
    except ShoecalError as error:
        return Applied(applied=False, told=str(error))
    made = outcome.calibration
    told = f"{made.verdict}: {'; '.join(made.reasons)}"
    if made.verdict != "PASS":
        return Applied(applied=False, told=told)
    worse = _error(member, outcome.stages.sensing) - _clean_error(member)
    return Applied(applied=True, told=told, worse=worse)


def _of(draw: Draw, cell: int, change: Callable[[FloatArray], FloatArray]) -> Injected:
    return Injected(draw.with_channel(cell, lambda values, _: change(values)), Expected(()))


def _error(member: Member, sensing: Sensing) -> float:
    """CoP error of each foot against the truth, in the recordings as they were [m]."""
    session = Session.open(member.folder)
    data = load_data(session)
    truths = {run: read_truth(session.truth_path(run)) for run in data.stances}
    pairs = [
        (measured_series(sensing, stance), truth_series(truths[run], stance))
        for run, stances in data.stances.items()
        for stance in stances
    ]
    return float(np.mean([foot.mean for foot in errors(pairs).foot_cop]))


@cache
def _clean_error(member: Member) -> float:
    outcome = calibrate_session(Session.open(member.folder), member.train, member.test)
    return _error(member, outcome.stages.sensing)
