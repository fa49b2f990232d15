"""A calibration held against everything that is known of a session's runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from shoecal_core.estimation.calibration import (
    Calibration,
    CalibrationFileError,
    WrongShoeError,
    load_calibration,
)
from shoecal_core.estimation.checks.accuracy import ModelLimit, check_accuracy, model_limit
from shoecal_core.estimation.checks.data_sheets import check_weight
from shoecal_core.estimation.checks.usable import check_zeros
from shoecal_core.estimation.comparison import read_truths
from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set
from shoecal_core.estimation.series import Series, measured_series, modelled_series, truth_series
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.estimation.weight import Weighed
from shoecal_core.files import sha256
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import ZeroFigures, zeros_json
from shoecal_core.screening.verdict import Finding, Verdict, judge
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.workflows.calibrate import rezeroed

MEASURED, MODELLED, REFERENCE, TRUTH = "measured", "modelled", "reference", "truth"
"""Sources of a run's series: calibration, model, the calibration taken as right, simulator."""

FITTED_TO_NO_RUN = ("manual", "identity")
"""Sources of calibrations for which every run of a session is new."""

OTHER_UNIT = 5.0
"""Factor on the weight that no gains are off by: they are of readings in another unit, as counts
are for volts."""


class WrongCalibrationError(CalibrationFileError):
    """A calibration file of another robot or of other shoes than the session's."""


def load_calibration_of(path: Path, session: Session) -> Calibration:
    """Read a calibration that belongs to the shoes and the robot of a session.

    Raises:
        WrongCalibrationError: for one of another shoe or another robot.
        FileError: as `load_calibration`.
    """
    calibration = load_calibration(path)
    where = f"session {session.folder}"
    if calibration.shoe != session.shoe.name:
        raise WrongCalibrationError(
            path,
            f"is of shoe '{calibration.shoe}', but {where} was recorded on "
            f"'{session.shoe.name}'; name a calibration of that shoe",
        )
    if calibration.robot != session.robot:
        raise WrongCalibrationError(
            path,
            f"is of robot '{calibration.robot}', but {where} is of '{session.robot}'; name a "
            "calibration of the shoes on that robot",
        )
    try:
        calibration.sensing(session.shoe)
    except WrongShoeError as error:
        raise WrongCalibrationError(path, str(error)) from error
    return calibration


def version_note(calibration: Calibration, session: Session) -> str:
    """What to know of a calibration made with another version of the shoe's file; else empty."""
    if calibration.shoe_hash == session.shoe.digest:
        return ""
    return (
        f"calibration '{calibration.id}' was made with another version of the file of shoe "
        f"'{calibration.shoe}' than session {session.folder}: where cells' places or plates have "
        "changed, calibrate again"
    )


def sets_for(
    session: Session, calibration: Calibration, train: Sequence[int], test: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Runs that a calibration was fitted to, and those that are new to it.

    Runs given count; else what the calibration says of itself; else the session's own marks;
    else every run counts as fitted.

    Raises:
        SessionError: a run that is not there, one in both sets, one given as a test run to which
            the calibration was fitted, or a session without runs.
    """
    entries = session.runs
    if not entries:
        raise SessionError(session.folder, "has no finished run; record one")
    fitted = {entry.run for entry in entries if sha256(entry.path) in calibration.fitted_runs}
    if train or test:
        train, test = split_runs(session, train, test)
        if wrong := sorted(fitted.intersection(test)):
            raise SessionError(
                session.folder,
                f"calibration '{calibration.id}' was fitted to run(s) "
                f"{', '.join(map(str, wrong))}: none of them is a test; name them with --train",
            )
        return train, test
    if calibration.fitted_runs or calibration.source in FITTED_TO_NO_RUN:
        runs = tuple(entry.run for entry in entries)
        return tuple(run for run in runs if run in fitted), tuple(
            run for run in runs if run not in fitted
        )
    return split_runs(session, (), ())


@dataclass(frozen=True)
class Evaluated:
    """A calibration on the runs of a session.

    Attributes:
        runs: the series of each, training runs first.
        zeros: what each foot reads in the air, as in result files.
        verdict: by the errors against the model, and by the zeros.
        weighed: the weight by data sheets; None where it cannot be known.
        limits: by set, what a walk's model leaves of the errors whatever the calibration.
        robot: that was recorded.
    """

    runs: list[ComparedRun]
    zeros: list[ZeroFigures]
    verdict: Verdict
    weighed: Weighed | None
    limits: Mapping[str, ModelLimit]
    robot: Robot


def evaluate_session(
    session: Session,
    calibration: Calibration,
    reference: Calibration | None = None,
    train: Sequence[int] = (),
    test: Sequence[int] = (),
    *,
    rezero: bool = False,
    weight_kg: float | None = None,
) -> Evaluated:
    """Compare on every run, and judge.

    The truth is used where every run has one. Arguments and errors as in `sets_for`, and:

    Args:
        reference: a calibration taken as right.
        rezero: apply the calibration with each run's own zeros, where a foot hangs in it.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
    """
    train, test = sets_for(session, calibration, train, test)
    data = load_data(session, (*train, *test), weight_kg=weight_kg)
    measuring = {MEASURED: calibration.sensing(data.shoe)}
    if reference is not None:
        measuring[REFERENCE] = reference.sensing(data.shoe)
    shoe, parameters = measuring[MEASURED].shoe, calibration.parameters
    zeros = zeros_json(shoe, data.zeros, parameters)
    judged = replace(data, shoe=shoe)
    own = data if not rezero else replace(data, stances=rezeroed(judged, parameters))
    runs = compare_data(session, own, {"train": train, "test": test}, measuring)
    if other := _of_another_unit(runs, data, calibration):
        return Evaluated(runs, zeros, judge([other]), data.weighed, {}, data.robot)
    findings = check_weight(shoe, parameters, calibration.gain_std, data.weighed, data.robot)
    findings += check_zeros(shoe, data.zeros, parameters, data.robot.weight, own=rezero)
    limits = {}
    for name, found in errors_by_set(runs, MEASURED, MODELLED).items():
        limit = model_limit(
            [
                pair
                for run in runs
                if run.set == name
                for pair in zip(run.sources[MEASURED], run.sources[MODELLED], strict=True)
            ]
        )
        if limit is not None:
            limits[name] = limit
        findings += check_accuracy(name, found, data.robot, limit, given=calibration.id)
    return Evaluated(runs, zeros, judge(findings), data.weighed, limits, data.robot)


def _of_another_unit(
    runs: Sequence[ComparedRun], data: SessionData, calibration: Calibration
) -> Finding | None:
    """The problem of gains that are of readings in another unit: nothing else is true then."""
    series = [one for run in runs for one in run.sources[MEASURED]]
    if not series:
        return None
    force = abs(float(np.median(np.concatenate([one.grf for one in series]))))
    weight = data.robot.weight
    if weight / OTHER_UNIT < force < weight * OTHER_UNIT:
        return None
    return Finding(
        "FAIL",
        f"by calibration '{calibration.id}' the robot weighs {force:.2g} N, where it weighs "
        f"{weight:.3g} N: its gains are of readings in another unit than these, which are in "
        f"{data.shoe.unit} by the shoe file; name a calibration of such readings, or calibrate "
        "this session",
    )


def compare_data(
    session: Session,
    data: SessionData,
    sets: Mapping[str, Sequence[int]],
    measuring: Mapping[str, Sensing],
) -> list[ComparedRun]:
    """Series by several calibrations, the model and the truth at the same instants.

    Args:
        session: that the data are of; its truth is used where every run has one.
        data: all runs that the sets name.
        sets: runs by `train` and `test`.
        measuring: the calibrated shoes by name.
    """
    sources: dict[str, Callable[[Stance], Series]] = {
        name: partial(measured_series, sensing) for name, sensing in measuring.items()
    }
    sources[MODELLED] = modelled_series
    truths = read_truths(session, data)
    if truths.keys() == data.stances.keys():
        sources[TRUTH] = lambda stance: truth_series(truths[stance.run], stance)
    return [
        ComparedRun(
            session=str(session.folder),
            run=run,
            set=name,
            sources={
                source: tuple(series_of(stance) for stance in data.stances[run])
                for source, series_of in sources.items()
            },
        )
        for name, runs in sets.items()
        for run in runs
        if data.stances[run]  # a robot that hangs stands nowhere
    ]
