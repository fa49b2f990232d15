"""docs/evidence/paper.md: every table and figure of the paper beside the reproduction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from paper_published import ASSUMPTIONS, CALIBRATED, GUESS, MANUAL
from paper_reproduction import GUESS as GUESSED
from paper_reproduction import STAGES, Paper, Reproduction
from paper_results import Quantity, missed, quantities
from shoecal_core.calibration.evaluate import Errors
from shoecal_core.calibration.evaluation import MEASURED, MODELLED, REFERENCE, TRUTH
from shoecal_core.calibration.metrics import Mae, cop_mae
from shoecal_core.calibration.run_errors import COMPARED, errors_by_set, errors_of
from shoecal_core.calibration.significance import Difference
from shoecal_core.sensing.shoe import FEET

UNITS = {"grf": "N", "cop": "mm"}
NAMES = {"grf": "GRF", "cop": "CoP"}
STAGE_NAMES = {
    "initial_guess": "initial guess",
    "least_squares": "nonlinear least squares",
    "self_calibration": "with CoP correction",
}

PAGE = """\
# The paper reproduced

Han, Jiang and Chirikjian, *Watch Me Calibrate My Force-Sensing Shoes!*, evaluate their method on
one real NAO: manual calibration, both assumptions, then the self-calibration against the manual
one. `make paper` does the same on simulated robots and writes this page, its figures
(`docs/figures/paper-*.svg`) and `out/paper.json`.

**Everything here is simulated** (MuJoCo, `config/realities/default.yaml`; five double supports
per robot, three to train). Errors (MAE ± standard deviation, the paper's equations 7 and 8) are
against the manual calibration, as in the paper, or against the *truth* from contact forces where
a table says so. Robot 1 (seed {first}) is compared with the paper's robot; it was not selected.
All {count} robots (seeds {seeds}) differ in masses, encoder zeros, cells and double supports.

## In short

{summary}

Targets (for robot 1 and for the median): {met}.

The simulated errors (plates, cell positions, scale, torso CoM) were tuned so that the manual
tables and the assumptions are similar to the paper's. **Their agreement shows that the simulation
is about as hard as the real robot, not that the method is right.** The self-calibration's errors
are a result.

## Manual calibration (Table I, Fig. 3)

{manual}

{figure_manual}

Differences: simulated cells have neither creep nor hysteresis, and readings average 50 samples,
so the GRF is ten times as accurate. The remaining CoP error is mostly the placement of the
weight. Points are drawn without the shoe's own weight. The last column (each load predicted by
the others) is not in the paper.

## Both assumptions (Table II, Fig. 5)

{assumptions}

{figure_assumptions}

Differences: the GRF error is mainly that of the scale and so the same in all runs, apart from
bursts at the start of a motion and where one foot carries little; on the real robot it varied.
The error of the modelled CoP is similar.

## Self-calibration (Figs. 6, 7 and 8)

Two training runs and both test runs of robot 1: motion, CoP, GRF.

{figure_train}

{figure_test}

{figure_errors}

All three stages against the manual calibration:

{stages}

Differences: the initial guess (one gain and one offset for all) varies by a factor of ten with
the cells drawn; the result does not depend on it. The CoP correction is kept only if it improves
held-out runs.

### Training against test runs

The paper finds no significant difference between training and test errors, without naming a test.
Here it is a [permutation test](../guide/evaluation.md#training-against-test-runs) over **runs**,
with {count} robots together.

{difference}

{verdict}

`p_value` in `out/paper.json` is the smaller of GRF and CoP against the manual calibration.

## Against the truth

Known only in simulation: the error of the manual reference, and of each foot.

{truth}

CoP error of one foot by the true force on it, all robots:

{by_load}

The manual calibration is an adequate reference; below its lightest weight (1 kg) it extrapolates.
The self-calibrated CoP of both feet is as accurate as the model. Single feet are worse: only the
yaw between the feet identifies their load sharing, and errors of one foot cancel in the other.

Samples with less than 2 N on a foot are excluded from its CoP; of robot 1
{left_out}.

## Not reproduced

Figs. 1 and 2 show the hardware, Fig. 4 sketches the planning (`shoecal_core/planning`).
"""

FIGURES = {
    "manual": "Manual calibration: GRF under known weights, CoP before and after correction",
    "assumptions": "GRF around the weight, modelled and manually calibrated CoP, five runs",
    "train": "Two training runs: motion, CoP and GRF by guess, manual and self-calibration",
    "test": "Two test runs, which were not fitted",
    "errors": "MAE of GRF and CoP, initial guess and self-calibration, training and test",
}
"""What is to be seen in each."""

MORE_ROBOTS = """\
No significance over so few robots does not show that there is no difference: with more
(`make paper ARGS="--seeds 40"`) the test finds smaller ones."""

BANDS = ((2.0, 10.0), (10.0, 30.0), (30.0, math.inf))
"""N; forces on a foot that are told apart."""


def page(paper: Paper) -> str:
    """The page as Markdown."""
    first = paper.first
    wrong = missed(paper)
    return PAGE.format(
        first=first.member.seed,
        count=len(paper.robots),
        seeds=f"{first.member.seed} to {paper.robots[-1].member.seed}",
        summary=_summary(paper),
        met="all met" if not wrong else "missed: " + "; ".join(wrong),
        manual=_manual(paper),
        assumptions=_assumptions(first),
        stages=_stages(paper),
        difference=_differences(paper),
        verdict=_verdict(paper),
        truth=_truth(paper),
        by_load=_by_load(paper),
        left_out=_left_out(paper),
        **{
            f"figure_{name}": f"![{alt}](../figures/paper-{name}.svg)"
            for name, alt in FIGURES.items()
        },
    )


def _summary(paper: Paper) -> str:
    rows = [
        ["MAE", "paper", "robot 1", f"{len(paper.robots)} robots: median (range)", "target"],
        ["---"] * 5,
        *(_summary_row(one, paper) for one in quantities()),
    ]
    return _table(rows)


def _summary_row(one: Quantity, paper: Paper) -> list[str]:
    least, most = one.bounds(paper.robots)
    target = "" if math.isinf(one.most) else f"at most {one.most:g}"
    if one.least:
        target = f"{one.least:g} to {one.most:g}"
    of_first = [_number(value, one.unit) for value in one.of(paper.first)]
    told = of_first[0] if len(of_first) == 1 else f"{min(of_first)} to {max(of_first)}"
    median = _number(one.median(paper.robots), one.unit)
    spread = f"{median} ({_number(least, one.unit)} to {_number(most, one.unit)})"
    return [f"{one.name} ({one.unit})", one.paper, told, spread, target]


def _number(value: float, unit: str) -> str:
    return f"{value:.3f}" if unit == "N" and value < 0.02 else f"{value:.2f}"


def _manual(paper: Paper) -> str:
    header = ["shoe", "", "GRF (N)", "CoP as measured (mm)", "CoP corrected (mm)"]
    rows = [[*header, "corrected, load held out (mm)"], ["---"] * 6]
    for index, name in enumerate(FEET):
        published, found = MANUAL[name], paper.first.manual.feet[index]
        rows.append([
            name, "paper", str(published.grf), str(published.cop_before),
            str(published.cop_after), "",
        ])  # fmt: skip
        grf = f"{found.grf.mean:.3f} ± {found.grf.std:.3f}"
        cop = [
            _mm(mae)
            for mae in (found.known_cop.before, found.known_cop.after, found.known_cop.held_out)
        ]
        rows.append(["", "robot 1", grf, *cop])
    return _table(rows)


def _assumptions(robot: Reproduction) -> str:
    found = [robot.assumption(run) for run in robot.in_order]
    runs = [f"run {run.run} ({run.set})" for run in robot.in_order]
    return _table([
        ["", *runs],
        ["---"] * (len(runs) + 1),
        ["GRF (N), paper", *(str(grf) for grf, _ in ASSUMPTIONS)],
        ["GRF (N), robot 1", *(_n(one.grf) for one in found)],
        ["CoP (mm), paper", *(str(cop) for _, cop in ASSUMPTIONS)],
        ["CoP (mm), robot 1", *(_mm(one.cop) for one in found)],
    ])  # fmt: skip


def _stages(paper: Paper) -> str:
    rows = [
        ["", "", "GRF (N)", "CoP (mm)"],
        ["---"] * 4,
        ["initial guess", "paper", f"about {GUESS[0]}", f"about {GUESS[1]}"],
        ["self-calibration, train and test", "paper", f"about {CALIBRATED[0]}",
         f"about {CALIBRATED[1]}"],
    ]  # fmt: skip
    for who, robots in (("robot 1", paper.robots[:1]), (_all(paper), paper.robots)):
        runs = [run for robot in robots for run in robot.runs]
        for stage, source in STAGES.items():
            for part, found in errors_by_set(runs, source, REFERENCE).items():
                rows.append([f"{STAGE_NAMES[stage]}, {part}", who, _n(found.grf), _mm(found.cop)])
    return _table(rows)


def _differences(paper: Paper) -> str:
    rows = [
        ["against", "MAE", "test minus train", "95 % interval", "p", "runs"],
        ["---"] * 6,
    ]
    for reference, label in ((REFERENCE, "manual calibration"), (TRUTH, "truth")):
        for name, found in paper.difference("self_calibration", reference).items():
            rows.append([label, NAMES[name], *_difference(name, found)])
    return _table(rows)


def _difference(name: str, found: Difference) -> list[str]:
    scale, _ = COMPARED[name]
    decimals = 3 if name == "grf" else 2
    value, low, high = (
        f"{scale * number:+.{decimals}f}" for number in (found.value, *found.interval)
    )
    unit = UNITS[name]
    return [
        f"{value} {unit}", f"{low} to {high} {unit}", f"{found.p_value:.2g}",
        f"{found.second} test, {found.first} training",
    ]  # fmt: skip


def _verdict(paper: Paper) -> str:
    found = paper.difference("self_calibration")
    different = [NAMES[name] for name, one in found.items() if one.significant]
    cop = found["cop"]
    most = 1e3 * cop.interval[1]
    if different:
        value = 1e3 * cop.value
        return (
            f"Training and test runs differ significantly in {' and '.join(different)}, the CoP by "
            f"{value:+.2f} mm."
        )
    return (
        "As in the paper, neither differs significantly at 5 %. That does not prove that nothing\n"
        f"is overfitted: the interval allows a CoP that is {most:.2f} mm worse on runs that were\n"
        f"not fitted.\n\n{MORE_ROBOTS}"
    )


def _truth(paper: Paper) -> str:
    header = ["against the truth", "", "GRF (N)", "CoP (mm)"]
    header += [f"{foot} {what}" for foot in FEET for what in ("GRF (N)", "CoP (mm)")]
    rows = [header, ["---"] * len(header)]
    for who, robots in (("robot 1", paper.robots[:1]), (_all(paper), paper.robots)):
        runs = [run for robot in robots for run in robot.runs]
        rows.append(["manual calibration", who, *_cells(errors_of(runs, REFERENCE, TRUTH))])
        rows.append(["model", who, *_cells(errors_of(runs, MODELLED, TRUTH))])
        for stage, source in STAGES.items():
            for part, found in errors_by_set(runs, source, TRUTH).items():
                rows.append([f"{STAGE_NAMES[stage]}, {part}", who, *_cells(found)])
    return _table(rows)


def _cells(found: Errors) -> list[str]:
    feet = zip(found.foot_grf, found.foot_cop, strict=True)
    each = [text for grf, cop in feet for text in (_n(grf), _mm(cop))]
    return [_n(found.grf), _mm(found.cop), *each]


def _by_load(paper: Paper) -> str:
    names = [f"{low:g} to {high:g} N" for low, high in BANDS[:-1]] + [f"above {BANDS[-1][0]:g} N"]
    rows = [["CoP of one foot (mm)", *names], ["---"] * (len(names) + 1)]
    for source, label in ((REFERENCE, "manual calibration"), (MEASURED, "self-calibration")):
        cells = [_mm(_foot_mae(paper, source, low, high)) for low, high in BANDS]
        rows.append([label, *cells])
    return _table(rows)


def _foot_mae(paper: Paper, source: str, low: float, high: float) -> Mae:
    """CoP error of feet that truly carry so much [m]."""
    found, wanted = [], []
    for run in paper.runs:
        for told, truth in zip(run.sources[source], run.sources[TRUTH], strict=True):
            chosen = (truth.foot_grf > low) & (truth.foot_grf <= high)
            found.append(told.foot_cop[chosen])
            wanted.append(truth.foot_cop[chosen])
    return cop_mae(np.concatenate(found), np.concatenate(wanted))


def _left_out(paper: Paper) -> str:
    told = []
    for source, label in ((REFERENCE, "the manual calibration"), (GUESSED, "the initial guess")):
        found = errors_of(paper.first.runs, source, TRUTH).foot_cop
        left, right = (f"{mae.left_out} of {mae.count + mae.left_out}" for mae in found)
        told.append(f"by {label} {left} on the left and {right} on the right")
    return ",\n".join(told)


def _all(paper: Paper) -> str:
    return f"{len(paper.robots)} robots"


def _n(mae: Mae) -> str:
    return f"{mae.mean:.2f} ± {mae.std:.2f}" if mae.count else ""


def _mm(mae: Mae) -> str:
    return f"{1e3 * mae.mean:.2f} ± {1e3 * mae.std:.2f}" if mae.count else ""


def _table(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
