"""One calibration against the truth, and against what was promised of its double supports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from population import nao
from shoecal_core.calibration.comparison import read_truths
from shoecal_core.calibration.evaluate import Errors, Series, errors, measured_series, truth_series
from shoecal_core.calibration.pipeline import Outcome, calibrate_session, load_data
from shoecal_core.files import read_yaml
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.forecast import Forecast, forecast, forecast_visits
from shoecal_core.planning.supports.observability import Visit, relative_information
from shoecal_core.recording.session import Session
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.load_cases import double_support_outputs
from shoecal_core.sensing.sensing import Sensing
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Result:
    """One calibration against the truth, and what was said of it before.

    Attributes:
        seed: of the robot.
        way: in which its double supports were chosen.
        grf, cop: MAE of both feet together [N, mm].
        foot_grf, foot_cop: MAE, mean of left and right [N, mm].
        worse_foot_cop: MAE of the worse foot [mm].
        gain: error of the gains, root mean square [%].
        rank: directions that the fit's data fixed, judged as a forecast is.
        promised_gain, promised_foot_grf: forecast before the motion [%, N].
        stated_gain, stated_foot_grf: the same from the information in the recording [%, N].
    """

    seed: int
    way: str
    grf: float
    cop: float
    foot_grf: float
    foot_cop: float
    worse_foot_cop: float
    gain: float
    rank: int
    promised_gain: float
    promised_foot_grf: float
    stated_gain: float
    stated_foot_grf: float


@dataclass(frozen=True)
class Floor:
    """What no choice of double supports can change, of all robots.

    Attributes:
        errors: under the true gains and offsets.
        sharing: (robots, 3, n) of `Examination.sharing` [N].
    """

    errors: tuple[Errors, ...]
    sharing: FloatArray


@dataclass(frozen=True)
class Examination:
    """What every calibration of one robot is measured against.

    Attributes:
        seed: of the robot.
        runs: stances beside their truth.
        true: the drawn gains and offsets.
    """

    seed: int
    runs: tuple[tuple[Stance, Series], ...]
    true: ChannelParameters

    @classmethod
    def of(cls, seed: int, session: Session) -> Examination:
        """By all runs of a session with truth."""
        data = load_data(session)
        truths = read_truths(session, data)
        drawn = read_yaml(session.truth_path(1).parent / "reality.yaml")
        gain, offset = (
            np.array([drawn.mapping(key).number(name) for name in data.shoe.names])
            for key in ("gain", "offset")
        )
        runs = tuple(
            (stance, truth_series(truths[run], stance))
            for run, stances in data.stances.items()
            for stance in stances
        )
        return cls(seed, runs, ChannelParameters(gain, offset))

    def sharing(self) -> FloatArray:
        """(3, n) of the channels' true outputs, root mean square over the runs [N].

        How they vary within a run, how that is off what a rigid body on equal springs makes of
        the same CoP, and how far their means are off it.
        """
        _, shoe = nao()
        found = []
        for stance, truth in self.runs:
            outputs = self.true.outputs(stance.readings)
            weight = float(truth.grf.mean())
            assumed = double_support_outputs(shoe, stance.support, weight, truth.cop)
            off = outputs - assumed
            found.append([outputs.std(axis=0), off.std(axis=0), off.mean(axis=0)])
        rms: FloatArray = np.sqrt(np.mean(np.square(found), axis=0))
        return rms

    def errors(self, sensing: Sensing) -> Errors:
        """Of the measured GRF and CoP."""
        return errors([(measured_series(sensing, stance), truth) for stance, truth in self.runs])


def examine(session: Session, way: str, examination: Examination) -> Result:
    """Calibrate from all runs of a session, and measure."""
    robot, shoe = nao()
    settings = PlannerSettings()
    outcome = calibrate_session(session)
    supports = [entry.info.support for entry in session.runs]
    visits = [Visit.expected(robot, support, settings) for support in supports if support]
    promised = forecast_visits(robot, shoe, visits, settings)
    stated = _stated(outcome, settings)
    found = examination.errors(outcome.stages.sensing)
    gain = outcome.calibration.parameters.gain / examination.true.gain - 1.0
    foot_cop = [1e3 * foot.mean for foot in found.foot_cop]
    return Result(
        seed=examination.seed,
        way=way,
        grf=found.grf.mean,
        cop=1e3 * found.cop.mean,
        foot_grf=float(np.mean([foot.mean for foot in found.foot_grf])),
        foot_cop=float(np.mean(foot_cop)),
        worse_foot_cop=max(foot_cop),
        gain=_percent(gain),
        rank=stated.rank,
        promised_gain=_percent(promised.gain_std),
        promised_foot_grf=_foot_grf(promised),
        stated_gain=_percent(stated.gain_std),
        stated_foot_grf=_foot_grf(stated),
    )


def _stated(outcome: Outcome, settings: PlannerSettings) -> Forecast:
    """The forecast's figures from the information in the recording."""
    robot, shoe = outcome.data.robot, outcome.data.shoe
    count = 2 * len(shoe.channels)
    fitted = outcome.stages.fit.information[:count, :count]
    known = relative_information(robot, shoe, outcome.calibration.parameters, fitted)
    return forecast(robot, shoe, known, settings)


def _percent(relative: FloatArray) -> float:
    return 100.0 * float(np.sqrt(np.mean(relative**2)))


def _foot_grf(found: Forecast) -> float:
    return float(np.sqrt(np.mean([foot.rms**2 for foot in found.error.foot_grf])))
