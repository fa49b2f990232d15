"""A session read, aligned with the model and screened: what a fit starts from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.checks.data_sheets import without_sheets
from shoecal_core.estimation.joint import SAMPLING
from shoecal_core.estimation.weight import Weighed, weigh
from shoecal_core.progress import Progress, no_progress
from shoecal_core.recording.errors import RecordingError, SessionError
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned, align
from shoecal_core.samples.filters import at_times
from shoecal_core.samples.missing import check_clocks, missing
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.sampling import make_samples
from shoecal_core.samples.settings import SampleSettings
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import Zero
from shoecal_core.screening.clocks.timing import timing_of
from shoecal_core.screening.extract import stances_of, zeros_of
from shoecal_core.screening.joints.legs import Legs, examine_legs
from shoecal_core.screening.joints.unmoved import describe_unmoved, unmoved_joint
from shoecal_core.screening.loads.hanging import hung_runs, leave_out_hung, without
from shoecal_core.screening.result import Screening
from shoecal_core.screening.screen import screen
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class SessionData:
    """A session read, aligned, screened and cut into stances: what every command starts from.

    Attributes:
        session: it was read from.
        kinematics, shoe: of what it was recorded with.
        runs: by number, as recorded.
        recorded: of each the readings, with the model's values by the stamps as they are.
        aligned: the same without the time offset that the screening found.
        stances: by number of the run.
        screening: what was found in it before the fit, and left out.
        zeros: of feet in the air, by run.
        hanging: runs in which both feet are in the air; once fitted, of the training runs.
        weighed: what the data sheets of the sensors make of the robot's weight; None where that
            cannot be known.
        problems: by run, why it is left out, or why it has no stances.
    """

    session: Session
    kinematics: Kinematics
    shoe: Shoe
    runs: Mapping[int, Run]
    recorded: Mapping[int, Aligned]
    aligned: Mapping[int, Aligned]
    stances: Mapping[int, tuple[Stance, ...]]
    screening: Screening = field(default_factory=Screening)
    zeros: tuple[Zero, ...] = ()
    hanging: frozenset[int] = frozenset()
    weighed: Weighed | None = None
    problems: Mapping[int, str] = field(default_factory=dict)

    @property
    def robot(self) -> Robot:
        """Shoes on."""
        return self.kinematics.robot

    def of(self, runs: Sequence[int]) -> list[Stance]:
        """Stances of some runs."""
        return [stance for run in runs for stance in self.stances[run]]

    @cached_property
    def samples(self) -> Samples | None:
        """Means of what a fit uses; None where the robot walks, or a cell is at fault."""
        read = [(run, self.aligned[number]) for number, run in self._loaded()]
        walks = any(run.info.support is None for run, _ in read)
        if walks or self.screening.fails:
            return None
        kept, air = self.screening.kept, self.screening.air
        return make_samples(read, self.shoe, self.kinematics, SAMPLING, kept, air)

    def whole_samples(self, settings: SampleSettings) -> Samples:
        """Means of all that was recorded, by the stamps as they are, with notes.

        For a diagnosis: what a fit leaves out or puts right may be the cause.

        Raises:
            ShoecalError: when no run can be used.
        """
        notes = [f"run {run} is left out: both feet are in the air" for run in sorted(self.hanging)]
        absent = self.problems.keys() - self.runs.keys()
        notes += [f"run {run} is left out: {self.problems[run]}" for run in sorted(absent)]
        read = []
        for number, run in self._loaded():
            try:
                check_clocks(run)
                read.append((run, self.recorded[number]))
            except RecordingError as error:
                notes.append(f"run {number} is left out: {error}")
        samples = make_samples(
            read, self.shoe, self.kinematics, settings, load=self._load(), notes=notes
        )
        if samples is None:
            reasons = "; ".join(notes) or "record some"
            raise SessionError(self.session.folder, f"no run can be used: {reasons}")
        return replace(samples, notes=(*notes, *missing(samples)))

    def _load(self) -> dict[int, FloatArray]:
        """(T, 2) by run, what each foot carries at the readings as recorded, where it is known."""
        return {
            run: at_times(load, self.aligned[run].time, self.recorded[run].time)
            for run, load in self.screening.load.items()
        }

    def _loaded(self) -> list[tuple[int, Run]]:
        """Runs in which a foot carries the robot."""
        return [(number, run) for number, run in self.runs.items() if not run.info.hanging]

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
    all_readable: bool = True,
    progress: Progress = no_progress,
) -> SessionData:
    """Read runs of a session (all of them by default) and align them with the model.

    Args:
        session: recorded.
        runs: numbers.
        settings: for a screening, which leaves out what is faulty; None: all is kept.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
        sheets: whether to believe the data sheets of its sensors.
        robot: in place of the session's own, shoes put on.
        all_readable: whether a run that cannot be used is an error; else it is left out, and
            `SessionData.problems` says why.
        progress: see `Progress`.

    Raises:
        ShoecalError: robot, shoe or, where all runs have to be readable, a run cannot be used.
    """
    shoe = session.shoe if sheets else without_sheets(session.shoe)
    if robot is None:
        robot = load_robot(session.robot_yaml, shoe, weight_kg=weight_kg)
    kinematics = Kinematics(robot)
    problems: dict[int, str] | None = None if all_readable else {}
    wanted = [entry.run for entry in session.runs] if runs is None else runs
    read: dict[int, Run] = {}
    recorded: dict[int, Aligned] = {}
    for index, number in enumerate(wanted):
        progress(f"reading run {number}", index / len(wanted))
        with noting(problems, number):
            run = session.read(number)
            recorded[number] = align(run, shoe, kinematics)
            read[number] = run
    loaded = {number: run for number, run in read.items() if not run.info.hanging}
    aligned, screening = recorded, Screening()
    legs = Legs()
    if settings is not None:
        # Before anything else is asked of them: nothing of what they read follows the motion.
        standing = {n: recorded[n] for n, run in loaded.items() if run.info.support is not None}
        hung = hung_runs(standing, shoe)
        loaded = {number: run for number, run in loaded.items() if number not in hung}
        timing = timing_of(loaded, recorded, shoe, robot.weight, settings)
        if timing.late != 0.0:
            aligned = {}
            for number, run in read.items():
                with noting(problems, number):
                    aligned[number] = align(run, shoe, kinematics, late_s=timing.late)
            read, loaded = ({n: runs[n] for n in aligned} for runs in (read, loaded))
        there = {number: aligned[number] for number in loaded}
        legs = examine_legs(loaded, there, shoe, kinematics, settings)
        screening = screen(loaded, there, shoe, robot.weight, settings, timing, legs)
        screening = _with_unmoved(screening, loaded, there, shoe, kinematics, settings)
        hung = {number: path for number, path in hung.items() if number in aligned}
        screening = leave_out_hung(screening, hung, aligned)
    stances: dict[int, tuple[Stance, ...]] = dict.fromkeys(read, ())
    zeros: list[Zero] = []
    for number, run in read.items():
        if legs.wrong:
            # The screening refuses them; what joint angles say of such a robot is wrong.
            break
        with noting(problems, number):
            zeros += zeros_of(run, aligned[number], shoe, kinematics, screening)
            stances[number] = tuple(stances_of(run, aligned[number], shoe, kinematics, screening))
    return SessionData(
        session=session,
        kinematics=kinematics,
        shoe=shoe,
        runs=read,
        recorded=recorded,
        aligned=aligned,
        stances=stances,
        screening=screening,
        zeros=tuple(zeros),
        hanging=frozenset(number for number, run in read.items() if run.info.hanging),
        weighed=weigh(
            shoe,
            {n: without(aligned[n], screening.hanging.get(n)).readings for n in loaded},
            zeros,
        ),
        problems=problems or {},
    )


def _with_unmoved(
    screening: Screening,
    runs: Mapping[int, Run],
    aligned: Mapping[int, Aligned],
    shoe: Shoe,
    kinematics: Kinematics,
    settings: CalibrationSettings,
) -> Screening:
    """A screening with the joint above the legs that does not move, where all else is sound."""
    if screening.fails:
        return screening
    left_out = screening.runs_left_out
    there = {
        run: aligned[run]
        for run, one in runs.items()
        if one.info.support is not None and run not in left_out
    }
    return screening.adding(describe_unmoved(unmoved_joint(there, shoe, kinematics, settings)))


@contextmanager
def noting(problems: dict[int, str] | None, run: int) -> Iterator[None]:
    """Within it, errors of this project are noted as a run's; with nowhere to note, raised."""
    try:
        yield
    except ShoecalError as error:
        if problems is None:
            raise
        problems.setdefault(run, str(error))
