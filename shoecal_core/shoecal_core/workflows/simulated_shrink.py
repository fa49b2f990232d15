"""How far the gap to a simulated robot shrinks once it has the effects that were found.

The simulator's world is that of the model, with cells of the calibrated gains and offsets, so that
its readings can be held against the recorded ones. It is put where the recorded robot stood and
is commanded what that one was; first without any effect, then with those found.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.result import Cause, Diagnosis, Evidence, SimulatedShrink
from shoecal_core.error_sources.base import split_name
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.fit import fit_parameters
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.residuals import unpack
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import Fields
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, combined, cop, foot_wrenches
from shoecal_core.simulation.effects.registry import EFFECTS, read_effect
from shoecal_core.workflows.many_jobs import over_cores
from shoecal_core.workflows.replayed import Replayed, like_the_model, replay

FloatArray = NDArray[np.float64]

SUFFIXES = {
    "s": "_s", "m": "_m", "rad": "_rad", "kg": "_kg", "N": "_n", "": "", "1/N": "_per_n",
    "1/N^2": "_per_n2", "N/s": "_n_per_s", "1/s": "_per_s", "N/K": "_n_per_k", "1/K": "_per_k",
    "rad/(N m)": "_rad_per_nm",
}  # fmt: skip
"""What a unit is called in the keys of a reality file."""
JUDGED = ("grf", "cop_x", "cop_y")
"""Signals that are compared."""


@dataclass(frozen=True)
class ReplayJob:
    """One run to be replayed in one world.

    Attributes:
        session: its folder. run: number.
        begun: of the run, since the session's first sample [s].
        parameters: of the simulated cells.
        items: the effects, as a reality file lists them.
    """

    session: Path
    run: int
    begun: float
    parameters: ChannelParameters
    items: tuple[dict[object, object], ...]


@dataclass(frozen=True)
class Difference:
    """Simulated minus recorded, over all samples.

    Attributes:
        voltage, grf, cop: mean absolute error, the CoP's a distance [the shoe's unit, N, m].
    """

    voltage: float
    grf: float
    cop: float


def with_simulated_shrink(diagnosis: Diagnosis, session: Session) -> Diagnosis:
    """The same diagnosis, `simulated` filled in: of all causes together that can be simulated.

    Those that cannot are listed in the notes.
    """
    able = [cause for cause in diagnosis.causes if _can_be_simulated(cause)]
    notes = [
        f"{cause.label} is no effect of the simulator: it was not simulated"
        for cause in diagnosis.causes
        if cause not in able
    ]
    shrink = None
    if able:
        try:
            shrink = _shrink(diagnosis, able, session)
        except ShoecalError as error:
            notes.append(f"nothing was simulated: {error}")
    causes = tuple(
        replace(cause, simulated=shrink if cause in able else None) for cause in diagnosis.causes
    )
    return replace(diagnosis, causes=causes, notes=(*diagnosis.notes, *notes))


def _can_be_simulated(cause: Cause) -> bool:
    return cause.effect in EFFECTS and all(one.unit in SUFFIXES for one in cause.size.values())


def items_of(cause: Cause) -> tuple[dict[object, object], ...]:
    """The cause as a reality file lists it; channels with sizes of their own each by itself."""
    sizes: dict[str, dict[object, object]] = {}
    for name, size in cause.size.items():
        component, channel = split_name(name)
        sizes.setdefault(channel, {})[f"{component}{SUFFIXES[size.unit]}"] = size.value
    found = []
    for channel, own in (sizes or {"": {}}).items():
        location = [channel] if channel else list(cause.location)
        item: dict[object, object] = {"effect": cause.effect, **own}
        if location:
            item["location"] = location
        if cause.run is not None:
            item["run"] = cause.run
        found.append(item)
    return tuple(found)


def replay_job(job: ReplayJob) -> Replayed:
    """Replay one run, in whatever process."""
    session = Session.open(job.session, force=True)  # checked when it was diagnosed
    shoe = session.shoe
    robot = load_robot(session.robot_yaml, shoe, urdf=session.robot_urdf)
    effects = [
        read_effect(Fields(Path("diagnosis"), str(item["effect"]), item)) for item in job.items
    ]
    drawn = like_the_model(robot, shoe, job.parameters, effects)
    return replay(session.read(job.run), robot, shoe, drawn, job.begun)


def _shrink(diagnosis: Diagnosis, causes: Sequence[Cause], session: Session) -> SimulatedShrink:
    """Of these causes together."""
    if not diagnosis.test:
        raise ShoecalError("there is no test run to compare with; name some with --test")
    settings = CalibrationSettings()
    data = load_data(session, diagnosis.train, settings)
    stances = [one for one in data.of(diagnosis.train) if one.hanging is None]
    worlds = (
        (_law(data.shoe, stances, settings), ()),
        (
            _law(data.shoe, _explained(stances, diagnosis.evidence), settings),
            tuple(item for cause in causes for item in items_of(cause)),
        ),
    )
    recorded = {run: session.read(run) for run in diagnosis.test}
    # Time counts from the first run that was diagnosed: others may be damaged.
    start = min(session.read(number).start_ns for number in (*diagnosis.train, *diagnosis.test))
    jobs = [
        ReplayJob(session.folder, number, 1e-9 * (run.start_ns - start), parameters, items)
        for parameters, items in worlds
        for number, run in recorded.items()
    ]
    found = _differences(jobs, recorded, session.shoe)
    before, after = _mean(found[: len(recorded)]), _mean(found[len(recorded) :])
    return SimulatedShrink(
        fraction=_removed(
            _square(before.grf, before.cop, settings), _square(after.grf, after.cop, settings)
        ),
        claimed=_claimed(diagnosis.evidence, settings),
        cop_mae_mm=(1e3 * before.cop, 1e3 * after.cop),
        grf_mae_n=(before.grf, after.grf),
        voltage_mae=(before.voltage, after.voltage),
    )


def _claimed(evidence: Evidence | None, settings: CalibrationSettings) -> float:
    """What the diagnosis says of the same on the test runs."""
    if evidence is None or evidence.explained is None:
        return 0.0
    column = [evidence.signals.index(name) for name in JUDGED]
    squares = []
    for fitted in (evidence.without, evidence.explained):
        rest = fitted.residuals[evidence.test][:, column]
        rest = rest[np.isfinite(rest).all(axis=1)]
        grf, place = np.abs(rest[:, 0]).mean(), np.linalg.norm(rest[:, 1:], axis=1).mean()
        squares.append(_square(float(grf), float(place), settings))
    return _removed(*squares)


def _law(shoe: Shoe, stances: Sequence[Stance], settings: CalibrationSettings) -> ChannelParameters:
    guess = initial_guess(shoe, stances, weight_row=False)
    return unpack(fit_parameters(shoe, stances, guess, settings).vector)[0]


def _explained(stances: Sequence[Stance], evidence: Evidence | None) -> list[Stance]:
    """Stances that are to be measured with what the explanation adds to GRF and CoP."""
    if evidence is None or evidence.explained is None:
        return list(stances)
    column = [evidence.signals.index(name) for name in JUDGED]
    added = np.nan_to_num(evidence.explained.contribution[:, column])
    explained = []
    for stance in stances:
        own = evidence.run == stance.run
        force, x, y = (
            np.interp(stance.time, evidence.time[own], values) for values in added[own].T
        )
        place = stance.cop + np.stack((x, y), axis=1)
        explained.append(replace(stance, force=stance.force + force, cop=place))
    return explained


def _differences(
    jobs: Sequence[ReplayJob],
    recorded: dict[int, Run],
    shoe: Shoe,
) -> list[Difference]:
    if multiprocessing.parent_process() is None:
        replayed = dict(over_cores(replay_job, jobs))
    else:  # one of many sessions: the cores are in use already
        replayed = {number: replay_job(job) for number, job in enumerate(jobs)}
    return [
        _difference(replayed[number], recorded[job.run], shoe, job.parameters)
        for number, job in enumerate(jobs)
    ]


def _difference(
    replayed: Replayed,
    run: Run,
    shoe: Shoe,
    parameters: ChannelParameters,
) -> Difference:
    recorded = np.stack(
        [np.interp(replayed.time, run.readings.time, one) for one in run.readings.value.T], axis=1
    )
    known = np.isfinite(recorded).all(axis=1)
    support = run.info.support or DoubleSupport(0.0, 0.0, 0.0)
    off = _shown(replayed.readings[known] - recorded[known], shoe, parameters)
    grf, place = (
        one - other
        for one, other in zip(
            *(
                _felt(readings[known], shoe, parameters, support)
                for readings in (replayed.readings, recorded)
            ),
            strict=True,
        )
    )
    loaded = np.isfinite(place).all(axis=1)
    length = np.linalg.norm(place[loaded], axis=1)
    return Difference(float(np.abs(off).mean()), float(np.abs(grf).mean()), float(length.mean()))


def _square(grf: float, cop_off: float, settings: CalibrationSettings) -> float:
    """Of mean errors of GRF [N] and CoP [m], in standard deviations.

    Means of sizes, not of squares: moments in which a foot lands a little earlier or later than
    in the recording would outweigh all others.
    """
    return (grf / settings.force_std_n) ** 2 + (cop_off / settings.cop_std_m) ** 2


def _removed(before: float, after: float) -> float:
    return 1.0 - after / before if before > 0.0 else 0.0


def _shown(off: FloatArray, shoe: Shoe, parameters: ChannelParameters) -> FloatArray:
    """Differences (T, n) of readings, less what no calibration could know of them.

    One pattern of a foot's offsets (+ - - + over four cells) changes neither force nor CoP: its
    mean is left out.
    """
    shown = parameters.gain * off
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        _, size, turned = np.linalg.svd(shoe.columns[own].T)
        hidden = turned[np.count_nonzero(size > 1e-9) :]
        shown[:, own] -= (shown[:, own].mean(axis=0) @ hidden.T) @ hidden
    return np.asarray(shown / parameters.gain)


def _felt(
    readings: FloatArray, shoe: Shoe, parameters: ChannelParameters, support: DoubleSupport
) -> tuple[FloatArray, FloatArray]:
    """GRF (T,) and CoP (T, 2) of both feet under one calibration."""
    wrench = combined(foot_wrenches(shoe, parameters.outputs(readings)), support)
    return wrench[:, 0], cop(wrench, MINIMUM_FORCE)


def _mean(differences: Sequence[Difference]) -> Difference:
    rows = [[one.voltage, one.grf, one.cop] for one in differences]
    return Difference(*np.mean(rows, axis=0).tolist())
