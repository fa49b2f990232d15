"""A session read, aligned with the model and screened: what a fit starts from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shoecal_core.errors import noting
from shoecal_core.estimation.data_sheets import without_sheets
from shoecal_core.estimation.joint import SAMPLING
from shoecal_core.estimation.weight import Weighed, weigh
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned, align_each
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.sampling import make_samples
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import Zero
from shoecal_core.screening.clocks import align_runs
from shoecal_core.screening.extract import stances_of, zeros_of
from shoecal_core.screening.result import Screening
from shoecal_core.screening.screen import screen
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class SessionData:
    """A session made ready for fitting.

    Attributes:
        robot, shoe: what it was recorded with.
        runs: by number, as recorded.
        aligned: of each the readings, with the model's values.
        stances: by number of the run.
        samples: means of all runs that stand; None where the robot walks, or without a screening.
        screening: what was found in it before the fit, and left out.
        zeros: of feet in the air, by run.
        hanging: runs in which both feet are in the air; once fitted, of the training runs.
        weighed: what the data sheets of the sensors make of the robot's weight; None where that
            cannot be known.
    """

    robot: Robot
    shoe: Shoe
    runs: Mapping[int, Run]
    aligned: Mapping[int, Aligned]
    stances: dict[int, tuple[Stance, ...]]
    samples: Samples | None
    screening: Screening = field(default_factory=Screening)
    zeros: tuple[Zero, ...] = ()
    hanging: frozenset[int] = frozenset()
    weighed: Weighed | None = None

    def of(self, runs: Sequence[int]) -> list[Stance]:
        """Stances of some runs."""
        return [stance for run in runs for stance in self.stances[run]]

    @property
    def end_ns(self) -> int:
        """Stamp of the last reading of all [ns since the epoch]; 0 without runs."""
        runs = self.runs.values()
        ends = (one.start_ns + round(1e9 * float(one.readings.time[-1])) for one in runs)
        return max(ends, default=0)

    @property
    def temperature(self) -> float:
        """Mean of what the device reported [degC], NaN where it reported none."""
        values = [run.readings.temperature for run in self.runs.values()]
        known = [one[np.isfinite(one)] for one in values]
        return float(np.mean(np.concatenate(known))) if any(map(len, known)) else float("nan")


def load_data(
    session: Session,
    runs: Sequence[int] | None = None,
    settings: CalibrationSettings | None = None,
    *,
    weight_kg: float | None = None,
    sheets: bool = True,
    robot: Robot | None = None,
    problems: list[str] | None = None,
) -> SessionData:
    """Read runs of a session (all of them by default) and align them with the model.

    Args:
        session: recorded.
        runs: numbers.
        settings: for a screening, which leaves out what is faulty; None: all is kept.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
        sheets: whether to believe the data sheets of its sensors.
        robot: in place of the session's own, shoes put on.
        problems: takes why runs are left out that cannot be read or aligned, and why others have no
            stances; None: that is an error.

    Raises:
        ShoecalError: robot, shoe or, without a list of problems, a run cannot be used.
    """
    shoe = session.shoe if sheets else without_sheets(session.shoe)
    if robot is None:
        robot = load_robot(session.robot_yaml, shoe, weight_kg=weight_kg)
    kinematics = Kinematics(robot)
    recorded: dict[int, Run] = {}
    for number in [entry.run for entry in session.runs] if runs is None else runs:
        with noting(problems):
            recorded[number] = session.read(number)
    late = 0.0
    if settings is None:
        aligned = align_each(recorded, shoe, kinematics, problems=problems)
    else:
        aligned, late = align_runs(recorded, shoe, kinematics, settings, problems)
    recorded = {number: recorded[number] for number in aligned}
    loaded = {number: run for number, run in recorded.items() if not run.info.hanging}
    read = [(run, aligned[number]) for number, run in loaded.items()]
    screening, samples = Screening(), None
    if settings is not None:
        there = {number: aligned[number] for number in loaded}
        screening = screen(loaded, there, shoe, robot.weight, settings, late)
        if read and all(run.info.support is not None for run, _ in read) and not screening.fails:
            samples = make_samples(read, shoe, kinematics, SAMPLING, screening.kept, screening.air)
    stances: dict[int, tuple[Stance, ...]] = dict.fromkeys(recorded, ())
    zeros: list[Zero] = []
    for number, run in recorded.items():
        with noting(problems):
            zeros += zeros_of(run, aligned[number], shoe, kinematics)
            stances[number] = tuple(stances_of(run, aligned[number], shoe, kinematics, screening))
    return SessionData(
        robot=robot,
        shoe=shoe,
        runs=recorded,
        aligned=aligned,
        stances=stances,
        samples=samples,
        screening=screening,
        zeros=tuple(zeros),
        hanging=frozenset(number for number, run in recorded.items() if run.info.hanging),
        weighed=weigh(shoe, {run.info.run: one.readings for run, one in read}, zeros),
    )
