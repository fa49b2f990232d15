"""Tables of the paper's evaluation next to the paper's figures.

A row is a dict by the heads of its columns. Errors are MAE ± standard deviation: GRF [N], CoP [mm].
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pages import Row
from paper_published import ASSUMPTIONS, CALIBRATED, MANUAL
from paper_published import GUESS as PUBLISHED_GUESS
from paper_reproduction import CORRECTED, GUESS, LEAST_SQUARES, Paper
from paper_targets import missed, of_all, summary
from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set, errors_of
from shoecal_core.estimation.series import Errors, Mae, cop_mae
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.evaluation import MEASURED, MODELLED, REFERENCE, TRUTH

GRF, COP = "GRF (N)", "CoP (mm)"
STAGES = {
    GUESS: "initial guess",
    LEAST_SQUARES: "least squares",
    CORRECTED: "with CoP correction",
    MEASURED: "joint fit",
}
"""The paper's own chain, and what `shoecal calibrate` does, as the tables call them."""
BANDS = {
    "2 to 10 N": (2.0, 10.0),
    "10 to 30 N": (10.0, 30.0),
    "above 30 N": (30.0, math.inf),
}
"""Forces on one foot."""


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


def manual(paper: Paper) -> Sequence[Row]:
    """Table I of the paper, and each load predicted by the others."""
    rows = []
    for name, found in zip(FEET, paper.first.manual.feet, strict=True):
        published, cop = MANUAL[name], found.known_cop
        columns = (GRF, "CoP as measured (mm)", "CoP corrected (mm)", "load held out (mm)")
        cells = (_n(found.grf, 3), _mm(cop.before), _mm(cop.after), _mm(cop.held_out))
        for whose, row in (("paper", (*published, "")), ("robot 1", cells)):
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
        *({"stage": name, "robot": "paper", GRF: grf, COP: cop} for name, (grf, cop) in published),
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
    """Test less training runs, robot by robot, and the signed-rank test over all robots."""
    rows = []
    for reference, name in ((REFERENCE, "manual calibration"), (TRUTH, "truth")):
        for key, found in paper.differences(reference).items():
            values = {"grf": 1.0, "cop": 1e3}[key] * found.values
            rows.append(
                {
                    "against": name,
                    "MAE": {"grf": GRF, "cop": COP}[key],
                    "test minus train, mean": f"{values.mean():+.3f}",
                    "least to most": f"{values.min():+.3f} to {values.max():+.3f}",
                    "p": f"{found.p_value:.2g}",
                    "robots": len(values),
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
        "all_robots": of_all(paper),
        "missed_targets": missed(paper),
    }
