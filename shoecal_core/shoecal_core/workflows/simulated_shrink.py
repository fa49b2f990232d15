"""How far the gap to a simulated robot shrinks once it has the effects that were found.

The simulator's world is that of the model. Its robot is put where the recorded one stood and is
commanded what that one was; first without any effect, then with those found. Each robot is
calibrated by what its own cells showed in the training runs, so that what a calibration absorbs of
an effect, it absorbs in both; then their calibrated GRF and CoP are compared on the test runs.

How two feet share their load hangs on joint angles that no encoder shows: single cells are loaded
otherwise in the replay. So it is reported how far the gap shrinks, but no cause is denied for that.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.result import Cause, Diagnosis, SimulatedShrink
from shoecal_core.error_sources.base import has_formula, split_name
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.fit import fit_parameters
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.residuals import unpack
from shoecal_core.estimation.session_data import SessionData
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

SUFFIXES = {
    "s": "_s", "m": "_m", "rad": "_rad", "kg": "_kg", "N": "_n", "": "", "1/N": "_per_n",
    "1/N^2": "_per_n2", "N/s": "_n_per_s", "1/s": "_per_s", "N/K": "_n_per_k", "1/K": "_per_k",
    "rad/(N m)": "_rad_per_nm",
}  # fmt: skip
"""What a unit is called in the keys of a reality file."""


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
        grf, cop: mean absolute error, the CoP's a distance [N, m].
    """

    grf: float
    cop: float


def with_simulated_shrink(
    diagnosis: Diagnosis, data: SessionData, settings: CalibrationSettings
) -> Diagnosis:
    """The same diagnosis, `simulated` filled in: of all causes together that can be simulated.

    Those that cannot are listed in the notes.

    Args:
        diagnosis: of the session.
        data: of its runs.
        settings: weights of the fit to recorded and replayed readings.
    """
    able = [cause for cause in diagnosis.causes if _can_be_simulated(cause)]
    notes = [
        f"{cause.label}: the simulator has no such law; it was not simulated"
        for cause in diagnosis.causes
        if cause not in able
    ]
    shrink = None
    if able:
        try:
            shrink = _shrink(diagnosis, able, data, settings)
        except ShoecalError as error:
            notes.append(f"nothing was simulated: {error}")
    causes = tuple(
        replace(cause, simulated=shrink if cause in able else None) for cause in diagnosis.causes
    )
    return replace(diagnosis, causes=causes, notes=(*diagnosis.notes, *notes))


def _can_be_simulated(cause: Cause) -> bool:
    known = cause.effect in EFFECTS and all(one.unit in SUFFIXES for one in cause.size.values())
    return known and has_formula(cause.size)


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
    robot = load_robot(session.robot_yaml, shoe)
    effects = [
        read_effect(Fields(Path("diagnosis"), str(item["effect"]), item)) for item in job.items
    ]
    drawn = like_the_model(robot, shoe, job.parameters, effects)
    return replay(session.read(job.run), robot, shoe, drawn, job.begun)


def _shrink(
    diagnosis: Diagnosis,
    causes: Sequence[Cause],
    data: SessionData,
    settings: CalibrationSettings,
) -> SimulatedShrink:
    """Of these causes together."""
    if not diagnosis.test:
        raise ShoecalError("there is no test run to compare with; name some with --test")
    stances = [one for one in data.of(diagnosis.train) if one.hanging is None]
    law = _law(data.shoe, stances, settings)
    train = tuple(sorted({one.run for one in stances}))
    recorded = {run: data.runs[run] for run in (*train, *diagnosis.test)}
    # Time counts from the first run that was diagnosed: others may be damaged.
    start = min(data.runs[number].start_ns for number in (*diagnosis.train, *diagnosis.test))
    worlds = ((), tuple(item for cause in causes for item in items_of(cause)))
    found = _replay(
        [
            ReplayJob(data.session.folder, number, 1e-9 * (run.start_ns - start), law, effects)
            for effects in worlds
            for number, run in recorded.items()
        ]
    )
    differences = []
    for replays in (found[: len(recorded)], found[len(recorded) :]):
        own = _law(data.shoe, _replayed_stances(stances, replays), settings)
        differences.append(
            _mean(
                [
                    _difference(one, recorded[one.run], data.shoe, own, law)
                    for one in replays
                    if one.run in diagnosis.test
                ]
            )
        )
    before, after = differences
    first, second = (_square(one, settings) for one in differences)
    return SimulatedShrink(
        fraction=1.0 - second / first if first > 0.0 else 0.0,
        cop_mae_mm=(1e3 * before.cop, 1e3 * after.cop),
        grf_mae_n=(before.grf, after.grf),
    )


def _law(shoe: Shoe, stances: Sequence[Stance], settings: CalibrationSettings) -> ChannelParameters:
    guess = initial_guess(shoe, stances, weight_row=False)
    return unpack(fit_parameters(shoe, stances, guess, settings).vector)[0]


def _replayed_stances(stances: Sequence[Stance], replays: Sequence[Replayed]) -> list[Stance]:
    """Stances with what the simulated cells showed in them."""
    by_run = {one.run: one for one in replays}
    found = []
    for stance in stances:
        own = by_run[stance.run]
        readings = [np.interp(stance.time, own.time, values) for values in own.readings.T]
        found.append(replace(stance, readings=np.stack(readings, axis=1)))
    return found


def _replay(jobs: Sequence[ReplayJob]) -> list[Replayed]:
    if multiprocessing.parent_process() is None:
        replayed = dict(over_cores(replay_job, jobs))
        return [replayed[number] for number in range(len(jobs))]
    return [replay_job(job) for job in jobs]  # one of many sessions: the cores are in use already


def _difference(
    replayed: Replayed,
    run: Run,
    shoe: Shoe,
    simulated: ChannelParameters,
    law: ChannelParameters,
) -> Difference:
    """Of a replay, under the simulated cells' calibration and the recorded ones' law."""
    recorded = np.stack(
        [np.interp(replayed.time, run.readings.time, one) for one in run.readings.value.T], axis=1
    )
    known = np.isfinite(recorded).all(axis=1)
    support = run.info.support or DoubleSupport(0.0, 0.0, 0.0)
    outputs = simulated.outputs(replayed.readings[known]), law.outputs(recorded[known])
    grf, place = (
        one - other
        for one, other in zip(*(_felt(one, shoe, support) for one in outputs), strict=True)
    )
    loaded = np.isfinite(place).all(axis=1)
    length = np.linalg.norm(place[loaded], axis=1)
    return Difference(float(np.abs(grf).mean()), float(length.mean()))


def _square(mean: Difference, settings: CalibrationSettings) -> float:
    """Of mean errors of GRF and CoP, in standard deviations.

    Means of sizes, not of squares: moments in which a foot lands a little earlier or later than
    in the recording would outweigh all others.
    """
    return (mean.grf / settings.force_std_n) ** 2 + (mean.cop / settings.cop_std_m) ** 2


def _felt(outputs: FloatArray, shoe: Shoe, support: DoubleSupport) -> tuple[FloatArray, FloatArray]:
    """GRF (T,) and CoP (T, 2) of both feet, of calibrated outputs (T, n)."""
    wrench = combined(foot_wrenches(shoe, outputs), support)
    return wrench[:, 0], cop(wrench, MINIMUM_FORCE)


def _mean(differences: Sequence[Difference]) -> Difference:
    rows = [[one.grf, one.cop] for one in differences]
    return Difference(*np.mean(rows, axis=0).tolist())
