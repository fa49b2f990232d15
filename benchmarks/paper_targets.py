"""Every figure that the paper gives, of the simulated robots, and the targets they must meet."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from pages import Row
from paper_published import CALIBRATED, MANUAL
from paper_published import GUESS as PUBLISHED_GUESS
from paper_reproduction import GUESS, Paper, Reproduction
from shoecal_core.estimation.run_errors import errors_by_set, errors_of
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.evaluation import MEASURED, REFERENCE

ALPHA = 0.05


@dataclass(frozen=True)
class Target:
    """The paper's figure in words, and where the first robot and the median of all must lie."""

    paper: str
    least: float = 0.0
    most: float = math.inf

    def __str__(self) -> str:
        if self.least:
            return f"{self.least:g} to {self.most:g}"
        return "" if math.isinf(self.most) else f"at most {self.most:g}"


TARGETS = {
    "manual, left: GRF (N)": Target(MANUAL["left"][0], most=0.03),
    "manual, left: CoP as measured (mm)": Target(MANUAL["left"][1], 3.0, 5.0),
    "manual, left: CoP corrected (mm)": Target(MANUAL["left"][2], most=1.07),
    "manual, right: GRF (N)": Target(MANUAL["right"][0], most=0.03),
    "manual, right: CoP as measured (mm)": Target(MANUAL["right"][1], 3.0, 5.0),
    "manual, right: CoP corrected (mm)": Target(MANUAL["right"][2], most=0.76),
    "weight against GRF, by run (N)": Target("0.12 to 0.31", most=0.31),
    "modelled CoP, by run (mm)": Target("2.01 to 2.98", most=3.0),
    "initial guess, all runs: GRF (N)": Target(PUBLISHED_GUESS[0]),
    "initial guess, all runs: CoP (mm)": Target(PUBLISHED_GUESS[1]),
    "self-calibration, train: GRF (N)": Target(CALIBRATED[0], most=0.35),
    "self-calibration, train: CoP (mm)": Target(CALIBRATED[1], most=2.8),
    "self-calibration, test: GRF (N)": Target(CALIBRATED[0], most=0.35),
    "self-calibration, test: CoP (mm)": Target(CALIBRATED[1], most=2.8),
}
"""By the names of `figures`."""


def figures(robot: Reproduction) -> dict[str, list[float]]:
    """MAE of one robot; several where the paper has one a run."""
    found = {}
    for side, foot in zip(FEET, robot.manual.feet, strict=True):
        found[f"manual, {side}: GRF (N)"] = [foot.grf.mean]
        found[f"manual, {side}: CoP as measured (mm)"] = [1e3 * foot.known_cop.before.mean]
        found[f"manual, {side}: CoP corrected (mm)"] = [1e3 * foot.known_cop.after.mean]
    by_run = [robot.assumption(run) for run in robot.in_order]
    found["weight against GRF, by run (N)"] = [one.grf.mean for one in by_run]
    found["modelled CoP, by run (mm)"] = [1e3 * one.cop.mean for one in by_run]
    stages = {"initial guess, all runs": errors_of(robot.runs, GUESS, REFERENCE)}
    for part, errors in errors_by_set(robot.runs, MEASURED, REFERENCE).items():
        stages[f"self-calibration, {part}"] = errors
    for name, errors in stages.items():
        found[f"{name}: GRF (N)"] = [errors.grf.mean]
        found[f"{name}: CoP (mm)"] = [1e3 * errors.cop.mean]
    return found


def of_all(paper: Paper) -> dict[str, list[float]]:
    """The same of all robots together."""
    robots = [figures(robot) for robot in paper.robots]
    return {name: [value for robot in robots for value in robot[name]] for name in TARGETS}


def summary(paper: Paper) -> list[Row]:
    """The first robot's figures next to the paper's, and the median and range of all."""
    first, every = figures(paper.first), of_all(paper)
    return [
        {
            "MAE": name,
            "paper": target.paper,
            "robot 1": _shown(first[name]),
            f"{len(paper.robots)} robots: median (range)": (
                f"{_shown([statistics.median(every[name])])} ({_shown(every[name])})"
            ),
            "target": str(target),
        }
        for name, target in TARGETS.items()
    ]


def missed(paper: Paper) -> list[str]:
    """Targets that are not met, in words."""
    first, every = figures(paper.first), of_all(paper)
    found = []
    for name, target in TARGETS.items():
        median = statistics.median(every[name])
        if not all(target.least <= value <= target.most for value in (*first[name], median)):
            found.append(
                f"{name}: {_shown(first[name])} on the first robot, median {_shown([median])}"
            )
    return found + [
        f"train and test differ in {name} (p = {difference.p_value:.3g})"
        for name, difference in paper.differences(REFERENCE).items()
        if difference.p_value <= ALPHA
    ]


def _shown(values: Sequence[float]) -> str:
    """The figure, or least and most of several."""
    low, high = (f"{end:.3f}" if end < 0.02 else f"{end:.2f}" for end in (min(values), max(values)))
    return low if len(values) == 1 else f"{low} to {high}"
