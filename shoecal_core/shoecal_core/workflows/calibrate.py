"""From a recorded session to a calibration that has been checked."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.axes import check_axes
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.accuracy import (
    ModelLimit,
    check_accuracy,
    check_promise,
    misfit,
    model_limit,
)
from shoecal_core.estimation.checks.data_sheets import (
    check_conflict,
    check_data_sheets,
    check_weight,
    contradicts,
)
from shoecal_core.estimation.checks.doubtful_files import check_files
from shoecal_core.estimation.checks.usable import (
    check_changed,
    check_directions,
    check_expected,
    check_gains,
    check_missing,
    check_robot,
    check_since,
    check_soles,
    check_zeros,
)
from shoecal_core.estimation.fit import SelfCalibration, prior_of, self_calibrate
from shoecal_core.estimation.freed_gears import free_gears
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.joint import corrected, fit_with_known, joint_calibration, of_joint
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.known import Since
from shoecal_core.estimation.known_shoe import known_shoe
from shoecal_core.estimation.lagging import check_lags, lags
from shoecal_core.estimation.leg_geometry import describe_leg_errors, leg_errors
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.residuals import ResidualWeights
from shoecal_core.estimation.series import Errors, Series, errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.estimation.uncertainty.assessment import Assessment, assess
from shoecal_core.estimation.walking_fit import (
    at_common_zeros,
    check_stances,
    common_zeros,
    stances_found,
    walks,
)
from shoecal_core.files import sha256
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.robot.double_support import count_distinct
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import with_own_zeros
from shoecal_core.screening.clocks.time_offsets import LEFT_STD_S, describe_time_offset
from shoecal_core.screening.result import Screening
from shoecal_core.screening.settings import PAPER, CalibrationSettings, require_prior_counts
from shoecal_core.screening.verdict import Finding, Verdict, judge
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import ChannelParameters

DISTINCT_SUPPORTS = 2
"""Gains and offsets of two feet cannot be separated in fewer double supports."""
SOURCE = "self"
"""Where the calibration is from, as it says."""


def calibrate_session(
    session: Session,
    train: Sequence[int] = (),
    test: Sequence[int] = (),
    settings: CalibrationSettings | None = None,
    tolerances: Tolerances | None = None,
    *,
    made_ns: int = 0,
    manual: Calibration | None = None,
    weight_kg: float | None = None,
    rezero: bool = False,
    sheets: bool = True,
    data: SessionData | None = None,
) -> CalibrationOutcome:
    """Self-calibration from a recording: by the joint fit, a walk by the least squares alone.

    Args:
        session: recorded.
        train, test: runs; see `split_runs`.
        settings: weights of the fit.
        tolerances: of what the files of robot and shoes say.
        made_ns: time stamp of the calibration [ns since the epoch]; 0: that of the last run.
        manual: calibration of these shoes with known weights, as a prior.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
        rezero: judge every run with its own zeros, where a foot hangs in it.
        sheets: whether to believe the data sheets of the sensors.
        data: of exactly these runs, where it was loaded already, with the same settings.

    Raises:
        ShoecalError: when no calibration can be had from the session at all. A calibration
            that was found but must not be used comes back with the verdict FAIL.
    """
    settings = CalibrationSettings() if settings is None else settings
    tolerances = Tolerances() if tolerances is None else tolerances
    train, test = split_runs(session, train, test)
    if manual is not None:
        require_prior_counts(settings)
        _require_no_walk(session, (*train, *test))
    if data is None:
        data = load_data(session, (*train, *test), settings, weight_kg=weight_kg, sheets=sheets)
    found = [*data.screening.findings, *check_missing(session.missing)]
    found += check_changed(session.changed_files if session.forced else ())
    if data.screening.fails:
        raise SessionError(session.folder, "; ".join(finding.reason for finding in found))
    data = replace(data, hanging=data.hanging.intersection(train))
    train, test = (tuple(run for run in runs if data.stances[run]) for runs in (train, test))
    _require_supports(session, data.of(train), found)

    def without_sheets() -> ChannelParameters | None:
        return _without_sheets(session, train, settings, tolerances, weight_kg)

    fit = _fit(
        session, data, train, settings, tolerances, manual, without_sheets if sheets else None
    )
    data, stages = fit.data, fit.stages
    assessment = assess(data.robot, stages, fit.joint, fit.training, settings, tolerances)
    if rezero:
        data = replace(data, stances=rezeroed(data, stages.parameters))
    compared = _compare(data, stages, {"train": train, "test": test})
    calibrated = compared["self_calibration"]
    limits = {name: model_limit(pairs) for name, pairs in calibrated.items()}
    promise: list[Finding] = []
    if fit.joint is not None:
        left = misfit(calibrated["train"])
        promise = check_promise(left, assessment.promised)
        assessment = assessment.not_below(left)
    modelled = {
        stage: {name: errors(pairs) for name, pairs in sets.items()}
        for stage, sets in compared.items()
    }
    if manual is not None:
        found += check_since(fit.since, manual.parameters, stages.parameters, data.shoe)
    found += _check_fit(fit, settings)
    found += check_stances(data.of(train))
    found += check_axes(data.shoe, data.of(train))
    found += check_zeros(data.shoe, data.zeros, stages.parameters, data.robot.weight, own=rezero)
    found = _check_sheets(fit, settings, tolerances, assessment) + found + promise
    moved = _moved(calibrated["train"])
    verdict = _verdict(data, stages, modelled["self_calibration"], limits, found, assessment, moved)
    return CalibrationOutcome(
        calibration=replace(
            _calibration(data, stages, assessment, verdict, made_ns),
            fitted_runs=tuple(sha256(entry.path) for entry in session.runs if entry.run in train),
        ),
        stages=stages,
        data=data,
        assessment=assessment,
        train=train,
        test=test,
        modelled=modelled,
        joint=fit.joint,
        limits={name: limit for name, limit in limits.items() if limit is not None},
    )


@dataclass(frozen=True)
class _Fit:
    """Gains and offsets, and what they were found from.

    Attributes:
        data: of the session, with what the fit puts right.
        training: stances that were fitted.
        stages, joint: how they were found; of a walk by the least squares alone.
        alone: gains and offsets without the data sheets, where these contradict the data.
        since: what has become of the shoes since a manual calibration that was given.
    """

    data: SessionData
    training: list[Stance]
    stages: SelfCalibration
    joint: JointFit | None
    alone: ChannelParameters | None = None
    since: Since | None = None


def _fit(
    session: Session,
    data: SessionData,
    train: Sequence[int],
    settings: CalibrationSettings,
    tolerances: Tolerances,
    manual: Calibration | None,
    without_sheets: Callable[[], ChannelParameters | None] | None,
) -> _Fit:
    """Fit the training runs; where data sheets contradict them, also without these.

    Args:
        without_sheets: such a fit; None: this is one.

    Raises:
        ShoecalError: when there is no fit.
    """
    std = settings.nominal_gain_std
    try:
        fit = _fit_once(data, train, _fitting(settings, data.screening), tolerances, manual)
    except ShoecalError as error:
        # Data sheets that are far off can keep a fit from settling at all.
        alone = None if without_sheets is None else without_sheets()
        if conflict := check_conflict(data.shoe, alone, alone, std):
            raise SessionError(session.folder, conflict[0].reason) from error
        raise
    if without_sheets is None or not contradicts(fit.data.shoe, fit.stages.parameters, std):
        return fit
    return replace(fit, alone=without_sheets())


def _without_sheets(
    session: Session,
    train: Sequence[int],
    settings: CalibrationSettings,
    tolerances: Tolerances,
    weight_kg: float | None,
) -> ChannelParameters | None:
    """Gains and offsets by the data alone; None where these do not fix them."""
    with suppress(ShoecalError):
        return calibrate_session(
            session, train, (), settings, tolerances, weight_kg=weight_kg, sheets=False
        ).calibration.parameters
    return None


def _fit_once(
    data: SessionData,
    train: Sequence[int],
    fitting: CalibrationSettings,
    tolerances: Tolerances,
    manual: Calibration | None,
) -> _Fit:
    training = data.of(train)
    if data.samples is None or fitting.method == PAPER:
        common = None
        if walks(training):
            common = common_zeros(data.shoe, data.zeros, train)
            training = at_common_zeros(data.shoe, training, data.zeros, common)
        return _Fit(data, training, self_calibrate(data.shoe, training, fitting, common), None)
    guess, guess_with_weight = (
        initial_guess(data.shoe, training, weight_row=row) for row in (False, True)
    )
    # Runs in which the robot was lifted for a while show zeros as those do in which it hangs.
    lifted = data.hanging.union(data.screening.hanging.keys() & set(train))
    hanging = [zero for zero in data.zeros if zero.run in lifted]
    solve = partial(
        joint_calibration, data.samples, train, guess, fitting, tolerances, hanging=hanging
    )
    if manual is None:
        joint, since = solve(), None
        shoe = joint.shoe
    else:
        sensing = manual.sensing(data.shoe)
        known = known_shoe(data.shoe, sensing, manual.covariance, data.robot.weight)
        joint, since = fit_with_known(solve, known)
        # Of steady shoes the weights on them have shown more than any motion does.
        shoe = sensing.shoe if since is Since.STEADY else joint.shoe
    data = replace(data, shoe=shoe, stances=corrected(data.stances, joint, shoe))
    stages = of_joint(joint, guess, guess_with_weight)
    if since is Since.STEADY:
        stages = replace(stages, shoe=shoe, corrections=sensing.corrections)
    return _Fit(data, data.of(train), stages, joint, since=since)


def rezeroed(data: SessionData, parameters: ChannelParameters) -> dict[int, tuple[Stance, ...]]:
    """Stances with readings as if each run's zeros were those of the parameters, by run."""
    found = {}
    for run, stances in data.stances.items():
        own = [zero for zero in data.zeros if zero.run == run]
        change = with_own_zeros(data.shoe, parameters, own).offset - parameters.offset
        shift = change / parameters.gain
        found[run] = tuple(replace(one, readings=one.readings + shift) for one in stances)
    return found


def _fitting(settings: CalibrationSettings, screening: Screening) -> CalibrationSettings:
    """Settings of the fit: of a time offset that is corrected already, little is left."""
    if screening.time_offset == 0.0:
        return settings
    left = min(settings.time_offset_std_s, LEFT_STD_S)
    return replace(settings, time_offset_std_s=left)


def _require_no_walk(session: Session, runs: Sequence[int]) -> None:
    """Refuse a manual calibration with runs whose fit would ignore it."""
    for entry in session.runs:
        if entry.run in runs and entry.info.support is None and not entry.info.hanging:
            raise SessionError(
                session.folder,
                f"run {entry.run} is of a walk, whose fit would ignore the manual calibration: "
                "calibrate without --manual, or from runs in double support alone (--train, "
                "--test)",
            )


def _require_supports(
    session: Session, stances: Sequence[Stance], found: Sequence[Finding]
) -> None:
    """Refuse what cannot fix the parameters whatever the noise."""
    double = [stance for stance in stances if all(stance.loaded)]
    if len({stance.hanging for stance in stances} - {None}) == 2:
        return  # each foot stood alone
    distinct = count_distinct(stance.support for stance in double)
    if distinct == 0 and found:
        reasons = "; ".join(finding.reason for finding in found)
        problem = f"none of the training runs can be used: {reasons}"
        raise SessionError(session.folder, problem)
    if distinct < DISTINCT_SUPPORTS:
        reasons = "".join(f"; {finding.reason}" for finding in found)
        if walks(stances):
            reasons = f"; {stances_found(stances)}{reasons}"
        raise SessionError(
            session.folder,
            f"{distinct} double support{'' if distinct == 1 else 's'} among the training runs; "
            f"record at least {DISTINCT_SUPPORTS} that differ in yaw (3 or more are better)"
            f"{reasons}",
        )


def _compare(
    data: SessionData, stages: SelfCalibration, sets: Mapping[str, Sequence[int]]
) -> dict[str, dict[str, list[tuple[Series, Series]]]]:
    """Measured and modelled series of each stance, by stage and set; an empty set is left out."""
    guess = Sensing(data.shoe, stages.guess.parameters)
    return {
        stage: {
            name: [
                (measured_series(sensing, stance), modelled_series(stance))
                for stance in data.of(runs)
            ]
            for name, runs in sets.items()
            if runs
        }
        for stage, sensing in (("initial_guess", guess), ("self_calibration", stages.sensing))
    }


def _moved(pairs: Sequence[tuple[Series, Series]]) -> float:
    """How far the modelled CoP, second of each pair, moves within a stance along an axis [m]."""
    known = [model.cop[np.isfinite(model.cop).all(axis=1)] for _, model in pairs]
    return float(max((np.ptp(cop, axis=0).max() for cop in known if len(cop)), default=0.0))


def _check_fit(fit: _Fit, settings: CalibrationSettings) -> list[Finding]:
    """Channels that lag behind what the fit expects of them."""
    fitting = _fitting(settings, fit.data.screening)
    prior = prior_of(fit.data.shoe, fit.stages.guess, fit.training, fitting)
    weights = ResidualWeights.of(fitting)
    return check_lags(fit.data.shoe, lags(fit.stages.fit.vector, prior, fit.training, weights))


def _check_sheets(
    fit: _Fit, settings: CalibrationSettings, tolerances: Tolerances, assessment: Assessment
) -> list[Finding]:
    """What data sheets and the weight say; it comes first, as their errors are in all gains."""
    data, gains = fit.data, fit.stages.parameters
    if conflict := check_conflict(data.shoe, gains, fit.alone, settings.nominal_gain_std):
        return conflict
    gain_std = np.sqrt(np.diag(assessment.covariance)[: len(data.shoe.names)])
    soles, robot = list[Finding](), list[Finding]()
    if fit.joint is not None:
        deviations = fit.joint.deviations
        soles = check_soles(data.shoe, deviations)
        robot = check_robot(deviations, partial(free_gears, fit.joint, tolerances))
    # A likelier cause stands for what the fit made of it, unless that is too far off to be applied.
    found = soles or _check_legs(data) or robot
    if robot != found and any(one.verdict == "FAIL" for one in robot):
        found = found + robot
    # Soles that are off bend the gains, too: only weighing in the air does not mind them.
    if not soles or data.weighed is not None:
        found += check_weight(data.shoe, gains, gain_std, data.weighed, data.robot)
    found += check_files(data.robot, data.shoe)
    return found + check_data_sheets(data.shoe, gains, gain_std)


def _check_legs(data: SessionData) -> list[Finding]:
    """Lengths and scales; an error of theirs looks like one of zeros or CoMs to the fit."""
    standing = {run: one for run, one in data.screening.standing.items() if run in data.aligned}
    return describe_leg_errors(leg_errors(data.kinematics, data.aligned, standing))


def _verdict(
    data: SessionData,
    stages: SelfCalibration,
    modelled: dict[str, Errors],
    limits: dict[str, ModelLimit | None],
    findings: list[Finding],
    assessment: Assessment,
    moved: float,
) -> Verdict:
    findings = findings + check_gains(data.shoe, stages.guess.polarity, stages.parameters)
    findings += describe_time_offset(stages.time_offset)
    for name, error in modelled.items():
        findings += check_accuracy(name, error, data.robot, limits[name])
    width, add = min(foot.half_width for foot in data.robot.feet), assessment.support_to_add
    expected = check_expected(width, *assessment.expected_cop(), add, moved)
    # Both have one cure, which stands once, with what is worse.
    findings += check_directions(assessment.identifiability, add, cure=not expected)
    return judge(findings + expected)


def _calibration(
    data: SessionData,
    stages: SelfCalibration,
    assessment: Assessment,
    verdict: Verdict,
    made_ns: int,
) -> Calibration:
    count, errors = len(data.shoe.names), assessment.error_model
    stamp = made_ns or data.end_ns
    digest = hashlib.sha256(stages.fit.vector.tobytes() + str(stamp).encode()).hexdigest()
    return Calibration(
        id=f"{SOURCE}-{digest[:12]}",
        source=SOURCE,
        made_ns=stamp,
        robot=data.robot.name,
        shoe=data.shoe.name,
        robot_hash=data.robot.digest,
        shoe_hash=data.shoe.digest,
        channels=data.shoe.names,
        parameters=stages.parameters,
        covariance=assessment.covariance[: 2 * count, : 2 * count],
        corrections=stages.corrections,
        weight=data.robot.weight,
        time_offset=data.screening.time_offset + stages.time_offset,
        temperature=data.temperature,
        verdict=verdict.verdict,
        reasons=verdict.reasons,
        columns=data.shoe.columns,
        column_covariance=(
            errors.stated.covariance[2 * count :] if len(errors.shoe_columns) else None
        ),
        support_covariance=errors.support_covariance,
    )
