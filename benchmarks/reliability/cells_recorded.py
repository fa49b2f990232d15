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
from reliability.tries import BrokenError
from shoecal_core.calibration.evaluate import errors, measured_series, truth_series
from shoecal_core.calibration.pipeline import calibrate_session, load_data
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.sensing.sensing import Sensing

FloatArray = NDArray[np.float64]

ROBOTS = 3
"""Sessions of the population, of that many robots."""
WORSE_M = 1e-3
"""By so much worse on the truth than without the fault a calibration is spoilt."""
PERIOD_S = 0.01
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
    if draw.rng.integers(2):
        level = float(draw.rng.choice([0.0, 5.0, -5.0]))
        return _of(draw, lambda values: np.full_like(values, level))
    share = float(draw.rng.uniform(0.0, 0.7))
    return _of(
        draw,
        lambda values: np.where(np.arange(len(values)) < share * len(values), values, np.nan),
    )


def not_a_number(draw: Draw) -> Injected:
    """Readings here and there that are none."""
    rng, share = draw.rng, float(draw.rng.uniform(0.01, 0.5))
    return _of(draw, lambda values: np.where(rng.random(len(values)) < share, np.nan, values))


def slow(draw: Draw) -> Injected:
    """Follows with a time constant of 0.2 to 2 s."""
    share = 1.0 - np.exp(-PERIOD_S / float(draw.rng.uniform(0.2, 2.0)))

    def late(values: FloatArray) -> FloatArray:
        followed = values.copy()
        for index in range(1, len(values)):
            followed[index] = followed[index - 1] + share * (values[index] - followed[index - 1])
        return followed

    return _of(draw, late)


def swapped(draw: Draw) -> Injected:
    """At another cell's place, of either foot."""
    order = np.arange(len(draw.shoe.names))
    cell, other = draw.cell(), int(draw.rng.choice(np.delete(order, draw.cell())))
    order[[cell, other]] = other, cell
    runs = {
        number: with_values(run, run.readings.value[:, order]) for number, run in draw.runs.items()
    }
    return Injected(runs, Expected(()))


def _of(draw: Draw, change: Callable[[FloatArray], FloatArray]) -> Injected:
    return Injected(draw.with_channel(draw.cell(), lambda values, _: change(values)), Expected(()))


RECORDED: Mapping[str, Callable[[Draw], Injected]] = {
    "off": off,
    "stuck": stuck,
    "saturated": saturated,
    "NaN": not_a_number,
    "spikes": spikes,
    "slow": slow,
    "swapped": swapped,
}


def check_recorded(fault: str, cell: int, number: int) -> None:
    """Calibrate from a session of which one cell was broken.

    Args:
        fault: one of RECORDED.
        cell: index.
        number: of the draw.

    Raises:
        BrokenError: when a calibration would be applied that the fault has spoilt.
    """
    members = different_robots(ROBOTS)
    for _ in sessions(members):  # makes those that are missing
        pass
    member = members[number % ROBOTS]
    draw: Draw = CellDraw(f"cells {fault}", number, member, nao()[1], chosen=cell)
    session = FaultySession.of(member.folder, _spoilt(draw, RECORDED[fault]))
    try:
        outcome = calibrate_session(session, member.train, member.test)
    except ShoecalError:
        return
    if outcome.calibration.verdict != "PASS":
        return
    worse = _error(member, outcome.stages.sensing) - _clean_error(member)
    if not worse < WORSE_M:
        raise BrokenError(f"cell {cell} {fault}: applied, {1e3 * worse:.1f} mm worse")


def _spoilt(draw: Draw, fault: Callable[[Draw], Injected]) -> dict[int, Run]:
    """All runs, with the fault."""
    for _ in range(ATTEMPTS):
        try:
            return draw.all_runs(fault(draw))
        except NoFaultError:
            draw = draw.again()
    raise BrokenError(f"{draw.fault}: no fault in {ATTEMPTS} attempts")


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
