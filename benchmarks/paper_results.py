"""The reproduction's figures beside the paper's, for machines, and the targets they must meet."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from operator import attrgetter

from paper_published import ASSUMPTIONS, CALIBRATED, GUESS, MANUAL
from paper_reproduction import STAGES, Paper, Reproduction
from shoecal_core.calibration.evaluate import Errors
from shoecal_core.calibration.evaluation import MEASURED, MODELLED, REFERENCE, TRUTH
from shoecal_core.calibration.manual.calibrate import FootResult
from shoecal_core.calibration.metrics import Mae
from shoecal_core.calibration.run_errors import differences_to_json, errors_by_set, errors_of
from shoecal_core.calibration.significance import LEVEL
from shoecal_core.sensing.shoe import FEET

ALPHA = round(1.0 - LEVEL, 6)


@dataclass(frozen=True)
class Quantity:
    """One figure of the paper.

    Attributes:
        name, unit: what it is.
        paper: the paper's, in words.
        of: figures of one robot; several where the paper has one a run.
        least, most: where it must lie; on the first robot, and in the median of all.
    """

    name: str
    unit: str
    paper: str
    of: Callable[[Reproduction], list[float]]
    least: float = 0.0
    most: float = float("inf")

    def median(self, robots: Iterable[Reproduction]) -> float:
        """Over all robots and runs."""
        return statistics.median(self._all(robots))

    def bounds(self, robots: Iterable[Reproduction]) -> tuple[float, float]:
        """Least and most over all robots and runs."""
        found = self._all(robots)
        return min(found), max(found)

    def met(self, paper: Paper) -> bool:
        """Whether the first robot and the median of all are within the target."""
        told = [*self.of(paper.first), self.median(paper.robots)]
        return all(self.least <= value <= self.most for value in told)

    def _all(self, robots: Iterable[Reproduction]) -> list[float]:
        return [value for robot in robots for value in self.of(robot)]


def quantities() -> list[Quantity]:
    """Every figure that the paper gives."""
    found = []
    for foot, name in enumerate(FEET):
        row = MANUAL[name]
        found += [
            Quantity(f"manual, {name}: GRF", "N", str(row.grf),
                     _manual(foot, attrgetter("grf"), 1.0), most=0.03),
            Quantity(f"manual, {name}: CoP as measured", "mm", str(row.cop_before),
                     _manual(foot, attrgetter("known_cop.before"), 1e3), 3.0, 5.0),
            Quantity(f"manual, {name}: CoP corrected", "mm", str(row.cop_after),
                     _manual(foot, attrgetter("known_cop.after"), 1e3), most=row.cop_after.mean),
        ]  # fmt: skip
    grf, cop = ([row[index].mean for row in ASSUMPTIONS] for index in (0, 1))
    found += [
        Quantity("weight against GRF, by run", "N", f"{min(grf):g} to {max(grf):g}",
                 lambda robot: [robot.assumption(run).grf.mean for run in robot.in_order],
                 most=max(grf)),
        Quantity("modelled CoP, by run", "mm", f"{min(cop):g} to {max(cop):g}",
                 lambda robot: [1e3 * robot.assumption(run).cop.mean for run in robot.in_order],
                 most=3.0),
        Quantity("initial guess, all runs: GRF", "N", f"about {GUESS[0]}", _stage("initial_guess")),
        Quantity("initial guess, all runs: CoP", "mm", f"about {GUESS[1]}",
                 _stage("initial_guess", cop=True)),
    ]  # fmt: skip
    for part in ("train", "test"):
        found += [
            Quantity(f"self-calibration, {part}: GRF", "N", f"about {CALIBRATED[0]}",
                     _stage("self_calibration", part), most=CALIBRATED[0].mean),
            Quantity(f"self-calibration, {part}: CoP", "mm", f"about {CALIBRATED[1]}",
                     _stage("self_calibration", part, cop=True), most=CALIBRATED[1].mean),
        ]  # fmt: skip
    return found


def _manual(
    foot: int, error: Callable[[FootResult], Mae], scale: float
) -> Callable[[Reproduction], list[float]]:
    return lambda robot: [scale * error(robot.manual.feet[foot]).mean]


def _stage(
    stage: str, part: str = "", *, cop: bool = False
) -> Callable[[Reproduction], list[float]]:
    def of(robot: Reproduction) -> list[float]:
        runs = [run for run in robot.runs if part in ("", run.set)]
        found = errors_of(runs, STAGES[stage], REFERENCE)
        return [1e3 * found.cop.mean if cop else found.grf.mean]

    return of


def p_values(paper: Paper, reference: str = REFERENCE) -> dict[str, float]:
    """Of train against test, GRF and CoP, over all robots."""
    return {
        name: found.p_value
        for name, found in paper.difference("self_calibration", reference).items()
    }


def missed(paper: Paper) -> list[str]:
    """Targets that are not met, in words."""
    found = [
        f"{one.name}: {', '.join(f'{value:.3g}' for value in one.of(paper.first))} on the first "
        f"robot, median {one.median(paper.robots):.3g} {one.unit}"
        for one in quantities()
        if not one.met(paper)
    ]
    return found + [
        f"train and test differ in {name} (p = {p:.3g})"
        for name, p in p_values(paper).items()
        if p <= ALPHA
    ]


def to_json(paper: Paper) -> dict[str, object]:
    """Everything; tables are those of the first robot, tests of all."""
    first = paper.first
    smallest = p_values(paper)
    return {
        "format": 1,
        "seed": first.member.seed,
        "seeds": [robot.member.seed for robot in paper.robots],
        "manual": _manual_json(first),
        "assumptions": [
            {"run": run.run, **first.assumption(run).to_json()} for run in first.in_order
        ],
        "self_calibration": {
            **_stages_json(first, REFERENCE),
            "p_value": min(smallest.values()),
            **{f"p_value_{name}": p for name, p in smallest.items()},
            "train_against_test": {
                f"against_{reference}": differences_to_json(
                    paper.difference("self_calibration", reference)
                )
                for reference in (REFERENCE, TRUTH)
            },
            "against_truth": _stages_json(first, TRUTH),
        },
        "reference_against_truth": errors_of(first.runs, REFERENCE, TRUTH).to_json(),
        "model_against_truth": errors_of(first.runs, MODELLED, TRUTH).to_json(),
        "all_robots": {
            one.name: {
                "unit": one.unit,
                "paper": one.paper,
                "median": one.median(paper.robots),
                "least": one.bounds(paper.robots)[0],
                "most": one.bounds(paper.robots)[1],
            }
            for one in quantities()
        },
        "missed_targets": missed(paper),
    }


def _manual_json(robot: Reproduction) -> Mapping[str, Mapping[str, float]]:
    def figures(foot: FootResult) -> dict[str, float]:
        return {
            "grf_mae_n": foot.grf.mean,
            "grf_std_n": foot.grf.std,
            "cop_before_mm": 1e3 * foot.known_cop.before.mean,
            "cop_before_std_mm": 1e3 * foot.known_cop.before.std,
            "cop_after_mm": 1e3 * foot.known_cop.after.mean,
            "cop_after_std_mm": 1e3 * foot.known_cop.after.std,
            "cop_held_out_mm": 1e3 * foot.known_cop.held_out.mean,
            "loads": foot.grf.count,
        }

    return {name: figures(foot) for name, foot in zip(FEET, robot.manual.feet, strict=True)}


def _stages_json(robot: Reproduction, reference: str) -> dict[str, object]:
    """Guess and least squares over all runs with their sets inside; the result by set."""

    def sets(source: str) -> dict[str, Errors]:
        return errors_by_set(robot.runs, source, reference)

    earlier = {
        stage: {
            **errors_of(robot.runs, source, reference).to_json(),
            **{name: found.to_json() for name, found in sets(source).items()},
        }
        for stage, source in STAGES.items()
        if source != MEASURED
    }
    return {**earlier, **{name: found.to_json() for name, found in sets(MEASURED).items()}}
