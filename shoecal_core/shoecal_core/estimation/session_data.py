"""A session read, aligned with the model and screened: what a fit starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from shoecal_core.estimation.data_sheets import without_sheets
from shoecal_core.estimation.joint import SAMPLING
from shoecal_core.estimation.weight import Weighed, weigh
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import align
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
        stances: by number of the run.
        samples: means of all runs that stand; None where the robot walks, or without a screening.
        start_ns: stamp that each run's times count from [ns since the epoch].
        end_ns: stamp of the last sample of all [ns since the epoch].
        temperature: mean of what the device reported [degC], NaN where it reported none.
        screening: what was found in it before the fit, and left out.
        zeros: of feet in the air, by run.
        hanging: runs in which both feet are in the air; once fitted, of the training runs.
        weighed: what the data sheets of the sensors make of the robot's weight; None where that
            cannot be known.
    """

    robot: Robot
    shoe: Shoe
    stances: dict[int, tuple[Stance, ...]]
    samples: Samples | None
    start_ns: dict[int, int]
    end_ns: int
    temperature: float
    screening: Screening = field(default_factory=Screening)
    zeros: tuple[Zero, ...] = ()
    hanging: frozenset[int] = frozenset()
    weighed: Weighed | None = None

    def of(self, runs: Sequence[int]) -> list[Stance]:
        """Stances of some runs."""
        return [stance for run in runs for stance in self.stances[run]]


def load_data(
    session: Session,
    runs: Sequence[int] | None = None,
    settings: CalibrationSettings | None = None,
    *,
    weight_kg: float | None = None,
    sheets: bool = True,
    robot: Robot | None = None,
) -> SessionData:
    """Read runs of a session (all of them by default) and align them with the model.

    Args:
        session: recorded.
        runs: numbers.
        settings: for a screening, which leaves out what is faulty; None: all is kept.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
        sheets: whether to believe the data sheets of its sensors.
        robot: in place of the session's own, shoes put on.
    """
    shoe = session.shoe if sheets else without_sheets(session.shoe)
    if robot is None:
        robot = load_robot(session.robot_yaml, shoe, urdf=session.robot_urdf, weight_kg=weight_kg)
    kinematics = Kinematics(robot)
    numbers = [entry.run for entry in session.runs] if runs is None else list(runs)
    recorded = {number: session.read(number) for number in numbers}
    if settings is None:
        aligned = {number: align(run, shoe, kinematics) for number, run in recorded.items()}
        screening = Screening()
    else:
        aligned, late = align_runs(recorded, shoe, kinematics, settings)
        loaded = {number: run for number, run in recorded.items() if not run.info.hanging}
        there = {number: aligned[number] for number in loaded}
        screening = screen(loaded, there, shoe, robot.weight, settings, late)
    samples = None
    read = [(run, aligned[number]) for number, run in recorded.items() if not run.info.hanging]
    standing = bool(read) and all(run.info.support is not None for run, _ in read)
    if settings is not None and standing and not screening.fails:
        samples = make_samples(
            read, robot, shoe, kinematics, SAMPLING, screening.kept, screening.air
        )
    zeros = [
        zero
        for number, run in recorded.items()
        for zero in zeros_of(run, aligned[number], shoe, kinematics)
    ]
    temperatures = [run.readings.temperature for run in recorded.values()]
    known = [values[np.isfinite(values)] for values in temperatures]
    return SessionData(
        robot=robot,
        shoe=shoe,
        stances={
            number: tuple(stances_of(run, aligned[number], shoe, kinematics, screening))
            for number, run in recorded.items()
        },
        samples=samples,
        start_ns={number: run.start_ns for number, run in recorded.items()},
        end_ns=max(
            (run.start_ns + round(1e9 * float(run.readings.time[-1])) for run in recorded.values()),
            default=0,
        ),
        temperature=float(np.mean(np.concatenate(known))) if any(map(len, known)) else float("nan"),
        screening=screening,
        zeros=tuple(zeros),
        hanging=frozenset(number for number, run in recorded.items() if run.info.hanging),
        weighed=weigh(shoe, {run.info.run: one.readings for run, one in read}, zeros),
    )
