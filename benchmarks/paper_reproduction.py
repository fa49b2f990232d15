"""One simulated robot goes through the paper's whole evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import wilcoxon

from population import Member
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.fit import self_calibrate
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.run_errors import SETS, ComparedRun, errors_of
from shoecal_core.estimation.series import Errors
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.manual.calibrate import ManualCalibration, calibrate_manually
from shoecal_core.recording.session import Session
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import PAPER, CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.evaluation import MEASURED, MODELLED, REFERENCE, compare_data
from shoecal_core.workflows.simulated_manual import simulate_manual
from shoecal_core.workspace import config_dir

GUESS, LEAST_SQUARES, CORRECTED = "guess", "least squares", "CoP correction"
"""Stages of the paper's own self-calibration (section VI)."""
SETTINGS = CalibrationSettings(method=PAPER)


@dataclass(frozen=True)
class Reproduction:
    """One robot.

    Attributes:
        member: its seeds.
        manual: calibration of its shoes on the loading rig: the reference.
        outcome: of its self-calibration.
        data: of its session, with every sample: what the calibration left out counts here, too.
        runs: what guess, calibration, model, reference and truth tell of each, training first.
    """

    member: Member
    manual: ManualCalibration
    outcome: CalibrationOutcome
    data: SessionData
    runs: tuple[ComparedRun, ...]

    @property
    def in_order(self) -> list[ComparedRun]:
        """Runs as they were recorded."""
        return sorted(self.runs, key=lambda run: run.run)

    def assumption(self, run: ComparedRun) -> Errors:
        """Weight and modelled CoP of a run against the reference (paper, Table II)."""
        return errors_of([run], MODELLED, REFERENCE)


def reproduce(member: Member, session: Session) -> Reproduction:
    """Calibrate the shoes by hand, the robot by itself, and compare.

    The shoes are loaded as the configuration describes them today; a session may have been
    recorded with an older version of the same file.
    """
    shoe, robot = shoe_and_robot()
    reality = load_reality(config_dir() / "realities" / "default.yaml")
    cells, loads = simulate_manual(shoe, reality, member.robot_seed, member.seed)
    manual = calibrate_manually(shoe, robot, cells, loads)
    outcome = calibrate_session(session, member.train, member.test)
    data = load_data(session, (*member.train, *member.test))
    chain = self_calibrate(data.shoe, data.of(member.train), SETTINGS)
    runs = compare_data(
        session,
        data,
        {"train": member.train, "test": member.test},
        {
            GUESS: Sensing(data.shoe, chain.guess.parameters),
            LEAST_SQUARES: Sensing(data.shoe, chain.parameters),
            CORRECTED: chain.sensing,
            MEASURED: outcome.calibration.sensing(data.shoe),
            REFERENCE: manual.calibration.sensing(data.shoe),
        },
    )
    return Reproduction(member, manual, outcome, data, tuple(runs))


def shoe_and_robot() -> tuple[Shoe, Robot]:
    """The NAO and its shoes, as configured."""
    shoe = load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")
    return shoe, load_robot(config_dir() / "robots" / "nao.yaml", shoe)


@dataclass(frozen=True)
class Difference:
    """Mean MAE of the test runs less that of the training runs, (robots,) [N or m]."""

    values: FloatArray

    @property
    def p_value(self) -> float:
        """Two-sided, of Wilcoxon's signed-rank test over the robots."""
        return float(wilcoxon(self.values).pvalue)


@dataclass(frozen=True)
class Paper:
    """All robots; the first one stands for the paper's one.

    Attributes:
        robots: in the order of their seeds.
    """

    robots: Sequence[Reproduction]

    @property
    def first(self) -> Reproduction:
        """The robot whose tables and figures stand beside the paper's."""
        return self.robots[0]

    @property
    def runs(self) -> list[ComparedRun]:
        """Of all robots."""
        return [run for robot in self.robots for run in robot.runs]

    def differences(self, reference: str) -> dict[str, Difference]:
        """GRF and CoP of the self-calibration: test less training runs, robot by robot."""
        found: dict[str, list[float]] = {"grf": [], "cop": []}
        for robot in self.robots:
            for name, values in found.items():
                maes = {
                    part: [
                        errors_of([run], MEASURED, reference).figures()[name][0].mean
                        for run in robot.runs
                        if run.set == part
                    ]
                    for part in SETS
                }
                values.append(float(np.mean(maes["test"]) - np.mean(maes["train"])))
        return {name: Difference(np.array(values)) for name, values in found.items()}
