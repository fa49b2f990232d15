"""Tables of the paper's evaluation next to the paper's figures, and the targets they must meet.

A row is a dict by the heads of its columns. Errors are MAE ± standard deviation: GRF [N], CoP [mm].
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pages import Row
from paper_published import ASSUMPTIONS, CALIBRATED, MANUAL
from paper_published import GUESS as PUBLISHED_GUESS
from paper_reproduction import GUESS, LEAST_SQUARES, Paper, Reproduction
from shoecal_core.calibration.evaluate import Errors
from shoecal_core.calibration.evaluation import MEASURED, MODELLED, REFERENCE, TRUTH
from shoecal_core.calibration.metrics import Mae, cop_mae
from shoecal_core.calibration.run_errors import COMPARED, ComparedRun, errors_by_set, errors_of
from shoecal_core.calibration.significance import LEVEL
from shoecal_core.sensing.shoe import FEET

ALPHA = round(1.0 - LEVEL, 6)
GRF, COP = "GRF (N)", "CoP (mm)"
STAGES = {
    GUESS: "initial guess",
    LEAST_SQUARES: "nonlinear least squares",
    MEASURED: "with CoP correction",
}
"""Of a self-calibration (paper, section VI), as the tables call them."""
BANDS = {
    "2 to 10 N": (2.0, 10.0),
    "10 to 30 N": (10.0, 30.0),
    "above 30 N": (30.0, math.inf),
}
"""Forces on one foot."""

Figures = Callable[[Reproduction], list[float]]


@dataclass(frozen=True)
class Quantity:
    """One figure of the paper.

    Attributes:
        name: with its unit.
        paper: the paper's, in words.
        of: figures of one robot; several where the paper has one a run.
        least, most: the target, for the first robot and for the median of all.
    """

    name: str
    paper: str
    of: Figures
    least: float = 0.0
    most: float = math.inf

    @property
    def target(self) -> str:
        """In words; nothing without one."""
        if self.least:
            return f"{self.least:g} to {self.most:g}"
        return "" if math.isinf(self.most) else f"at most {self.most:g}"

    def of_all(self, paper: Paper) -> list[float]:
        """Figures of all robots."""
        return [value for robot in paper.robots for value in self.of(robot)]

    def met(self, paper: Paper) -> bool:
        """Whether the first robot and the median of all are within the target."""
        found = [*self.of(paper.first), statistics.median(self.of_all(paper))]
        return all(self.least <= value <= self.most for value in found)


def quantities() -> list[Quantity]:
    """Every figure that the paper gives."""
    found = []
    for foot, name in enumerate(FEET):
        row, grf, before, after = MANUAL[name], *_manual(foot)
        found += [
            Quantity(f"manual, {name}: {GRF}", str(row.grf), grf, most=0.03),
            Quantity(
                f"manual, {name}: CoP as measured (mm)", str(row.cop_before), before, 3.0, 5.0
            ),
            Quantity(
                f"manual, {name}: CoP corrected (mm)",
                str(row.cop_after),
                after,
                most=row.cop_after.mean,
            ),
        ]
    grf_by_run, cop_by_run = ([row[index].mean for row in ASSUMPTIONS] for index in (0, 1))
    found += [
        Quantity(
            "weight against GRF, by run (N)",
            f"{min(grf_by_run):g} to {max(grf_by_run):g}",
            lambda robot: [robot.assumption(run).grf.mean for run in robot.in_order],
            most=max(grf_by_run),
        ),
        Quantity(
            "modelled CoP, by run (mm)",
            f"{min(cop_by_run):g} to {max(cop_by_run):g}",
            lambda robot: [1e3 * robot.assumption(run).cop.mean for run in robot.in_order],
            most=3.0,
        ),
    ]
    for name, stage, part, published in (
        ("initial guess, all runs", GUESS, "", PUBLISHED_GUESS),
        ("self-calibration, train", MEASURED, "train", CALIBRATED),
        ("self-calibration, test", MEASURED, "test", CALIBRATED),
    ):
        errors = _errors(stage, part)
        for unit, mae, error in zip((GRF, COP), published, errors, strict=True):
            most = math.inf if stage == GUESS else mae.mean
            found.append(Quantity(f"{name}: {unit}", f"about {mae}", error, most=most))
    return found


def _manual(foot: int) -> tuple[Figures, Figures, Figures]:
    """GRF [N], CoP as measured and corrected [mm] of a shoe under known weights."""
    return (
        lambda robot: [robot.manual.feet[foot].grf.mean],
        lambda robot: [1e3 * robot.manual.feet[foot].known_cop.before.mean],
        lambda robot: [1e3 * robot.manual.feet[foot].known_cop.after.mean],
    )


def _errors(stage: str, part: str) -> tuple[Figures, Figures]:
    """GRF [N] and CoP [mm] of a stage against the manual calibration, on a set or on all runs."""

    def found(robot: Reproduction) -> Errors:
        runs = [run for run in robot.runs if part in ("", run.set)]
        return errors_of(runs, stage, REFERENCE)

    return lambda robot: [found(robot).grf.mean], lambda robot: [1e3 * found(robot).cop.mean]


def missed(paper: Paper) -> list[str]:
    """Targets that are not met, in words."""
    return [
        *(
            f"{one.name}: {_number(one.of(paper.first))} on the first robot, "
            f"median {_number([statistics.median(one.of_all(paper))])}"
            for one in quantities()
            if not one.met(paper)
        ),
        *(
            f"train and test differ in {name} (p = {found.p_value:.3g})"
            for name, found in paper.differences(REFERENCE).items()
            if found.p_value <= ALPHA
        ),
    ]


def tables(paper: Paper) -> dict[str, Sequence[Row]]:
    """By the sections of docs/evidence/paper.md."""
    return {
        "summary": summary(paper),
        "manual": manual(paper),
        "assumptions": assumptions(paper),
        "stages": stages(paper),
        "differences": differences(paper),
        "truth": truth(paper),
        "by-load": by_load(paper),
    }


def summary(paper: Paper) -> Sequence[Row]:
    """Every figure of the paper, the first robot's, and the median and range of all."""
    rows = []
    for one in quantities():
        every = one.of_all(paper)
        spread = f"{_number([statistics.median(every)])} ({_number(every)})"
        rows.append(
            {
                "MAE": one.name,
                "paper": one.paper,
                "robot 1": _number(one.of(paper.first)),
                f"{_all(paper)}: median (range)": spread,
                "target": one.target,
            }
        )
    return rows


def _number(values: Sequence[float]) -> str:
    """The figure, or least and most of several."""
    low, high = (f"{end:.3f}" if end < 0.02 else f"{end:.2f}" for end in (min(values), max(values)))
    return low if len(values) == 1 else f"{low} to {high}"


def manual(paper: Paper) -> Sequence[Row]:
    """Table I of the paper, and each load predicted by the others."""
    rows = []
    for name, found in zip(FEET, paper.first.manual.feet, strict=True):
        published, cop = MANUAL[name], found.known_cop
        columns = (GRF, "CoP as measured (mm)", "CoP corrected (mm)", "load held out (mm)")
        paper_cells = (published.grf, published.cop_before, published.cop_after, "")
        cells = (_n(found.grf, 3), _mm(cop.before), _mm(cop.after), _mm(cop.held_out))
        for whose, row in (("paper", paper_cells), ("robot 1", cells)):
            rows.append({"shoe": name, "robot": whose, **dict(zip(columns, row, strict=True))})
    return rows


def assumptions(paper: Paper) -> Sequence[Row]:
    """Table II of the paper: weight and modelled CoP against the manual calibration, by run."""
    robot = paper.first
    return [
        {
            "run": f"{run.run} ({run.set})",
            "GRF (N), paper": published[0],
            "GRF (N), robot 1": _n(robot.assumption(run).grf),
            "CoP (mm), paper": published[1],
            "CoP (mm), robot 1": _mm(robot.assumption(run).cop),
        }
        for run, published in zip(robot.in_order, ASSUMPTIONS, strict=False)
    ]


def stages(paper: Paper) -> Sequence[Row]:
    """All stages of the self-calibration against the manual calibration."""
    published = (
        ("initial guess", PUBLISHED_GUESS),
        ("self-calibration, train and test", CALIBRATED),
    )
    return [
        *(
            {"stage": name, "robot": "paper", GRF: f"about {grf}", COP: f"about {cop}"}
            for name, (grf, cop) in published
        ),
        *(
            {"stage": name, "robot": who, GRF: _n(found.grf), COP: _mm(found.cop)}
            for who, runs in _robots(paper)
            for name, found in _by_stage(runs, REFERENCE).items()
        ),
    ]


def truth(paper: Paper) -> Sequence[Row]:
    """Manual calibration, model and all stages against the truth, of the body and by foot."""
    rows = []
    for who, runs in _robots(paper):
        compared = {
            "manual calibration": errors_of(runs, REFERENCE, TRUTH),
            "model": errors_of(runs, MODELLED, TRUTH),
            **_by_stage(runs, TRUTH),
        }
        for name, found in compared.items():
            row = {"against the truth": name, "robot": who, GRF: _n(found.grf), COP: _mm(found.cop)}
            for foot, side in enumerate(FEET):
                row[f"{side} {GRF}"] = _n(found.foot_grf[foot])
                row[f"{side} {COP}"] = _mm(found.foot_cop[foot])
            rows.append(row)
    return rows


def _robots(paper: Paper) -> list[tuple[str, list[ComparedRun]]]:
    """Runs of the first robot and of all, with their names."""
    return [("robot 1", list(paper.first.runs)), (_all(paper), paper.runs)]


def _all(paper: Paper) -> str:
    return f"{len(paper.robots)} robots"


def _by_stage(runs: Sequence[ComparedRun], reference: str) -> dict[str, Errors]:
    return {
        f"{name}, {part}": found
        for stage, name in STAGES.items()
        for part, found in errors_by_set(runs, stage, reference).items()
    }


def differences(paper: Paper) -> Sequence[Row]:
    """Training against test runs: the permutation test over all robots."""
    rows = []
    for reference, name in ((REFERENCE, "manual calibration"), (TRUTH, "truth")):
        for key, found in paper.differences(reference).items():
            scale = COMPARED[key][0]
            shift, low, high = (f"{scale * end:+.3f}" for end in (found.value, *found.interval))
            rows.append(
                {
                    "against": name,
                    "MAE": {"grf": GRF, "cop": COP}[key],
                    "test minus train": shift,
                    "95 % interval": f"{low} to {high}",
                    "p": f"{found.p_value:.2g}",
                    "runs": f"{found.second} test, {found.first} training",
                }
            )
    return rows


def by_load(paper: Paper) -> Sequence[Row]:
    """CoP error of one foot by the true force on it, all robots."""
    return [
        {
            "CoP of one foot (mm)": name,
            **{band: _mm(_foot_cop(paper, source, *ends)) for band, ends in BANDS.items()},
        }
        for source, name in ((REFERENCE, "manual calibration"), (MEASURED, "self-calibration"))
    ]


def _foot_cop(paper: Paper, source: str, low: float, high: float) -> Mae:
    """CoP error [m] of feet that truly carry between two forces [N]."""
    found, wanted = [], []
    for run in paper.runs:
        for one, true in zip(run.sources[source], run.sources[TRUTH], strict=True):
            chosen = (true.foot_grf > low) & (true.foot_grf <= high)
            found.append(one.foot_cop[chosen])
            wanted.append(true.foot_cop[chosen])
    return cop_mae(np.concatenate(found), np.concatenate(wanted))


def _n(mae: Mae, decimals: int = 2) -> str:
    return f"{mae.mean:.{decimals}f} ± {mae.std:.{decimals}f}" if mae.count else ""


def _mm(mae: Mae) -> str:
    return f"{1e3 * mae.mean:.2f} ± {1e3 * mae.std:.2f}" if mae.count else ""


def to_json(paper: Paper) -> dict[str, object]:
    """Figures of the first robot; p values, tables and targets of all."""
    first = paper.first
    calibrated = errors_by_set(first.runs, MEASURED, REFERENCE)
    p_values = {name: one.p_value for name, one in paper.differences(REFERENCE).items()}
    return {
        "format": 2,
        "seed": first.member.seed,
        "seeds": [robot.member.seed for robot in paper.robots],
        "manual": {
            name: {
                "grf_mae_n": foot.grf.mean,
                "cop_before_mm": 1e3 * foot.known_cop.before.mean,
                "cop_after_mm": 1e3 * foot.known_cop.after.mean,
                "cop_held_out_mm": 1e3 * foot.known_cop.held_out.mean,
            }
            for name, foot in zip(FEET, first.manual.feet, strict=True)
        },
        "assumptions": [
            {"run": run.run, **first.assumption(run).to_json()} for run in first.in_order
        ],
        "self_calibration": {
            "initial_guess": errors_of(first.runs, GUESS, REFERENCE).to_json(),
            **{name: found.to_json() for name, found in calibrated.items()},
            "p_value": min(p_values.values()),
            **{f"p_value_{name}": p for name, p in p_values.items()},
        },
        "all_robots": {one.name: one.of_all(paper) for one in quantities()},
        "missed_targets": missed(paper),
    }
