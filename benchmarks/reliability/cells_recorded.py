"""Cells that are broken while a calibration is recorded: is one ever applied that they spoilt?"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from caught_faults import ATTEMPTS, clean_cop_errors, cop_errors
from fault_cables import saturated, spikes, stuck, with_values
from fault_draws import Draw, Expected, FaultySession, Injected, NoFaultError
from population import different_robots, nao, sessions
from reliability.tries import BrokenError
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import Run
from shoecal_core.workflows.calibrate import calibrate_session

ROBOTS = 3
"""Sessions of the population, of that many robots."""
WORSE_MM = 1.0
"""By so much worse on the truth than without the fault a calibration is spoilt."""
PERIOD_S = 0.01


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
    clean = clean_cop_errors(member)
    found = cop_errors(member, outcome.stages.sensing, list(clean))
    worse = np.mean(list(found.values())) - np.mean(list(clean.values()))
    if not worse < WORSE_MM:
        raise BrokenError(f"cell {cell} {fault}: applied, {worse:.1f} mm worse")


def _spoilt(draw: Draw, fault: Callable[[Draw], Injected]) -> dict[int, Run]:
    """All runs, with the fault."""
    for _ in range(ATTEMPTS):
        try:
            return draw.all_runs(fault(draw))
        except NoFaultError:
            draw = draw.again()
    raise BrokenError(f"{draw.fault}: no fault in {ATTEMPTS} attempts")
