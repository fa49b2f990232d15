"""The tables of docs/evidence/robots.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from humanoids import PACKAGE, version
from pages import table
from shoecal_core.model.robot import GRAVITY

HEAD = """\
# Other robots

Humanoids of other makers, from descriptions that are public: drafted, planned, calibrated.
**Everything here is simulated.** How a robot is put to use, step by step:
[your robot](../how-to/your-robot.md); the robot of its examples is *wren*, a small humanoid of 3.6 kg
with three cells a foot that nobody built.
"""

TEXT = """\
## From a URDF to a calibration, nothing by hand
Made by `make robots`: seed {seed}, {supports} double supports, of which the first {train} train.
The descriptions are those of the package `{package}` {version}, which the command installs; none of
them is part of this project. Robot file and shoe file of each are what `shoecal new robot` drafts,
unchanged: soles from the feet's shapes, masses as published, a cell under each corner of the sole
where the ankles have no six-axis sensor.

{robots}

Named: the URDF tells of the sensors; where it does not, `--six-axis` says so. Time in motion is the
robot's, all double supports together. Processor time is that of the commands `new robot`,
`simulate` (finding double supports, planning, physics, recording) and `calibrate` on one core of
the machine that [performance](performance.md) names.

Errors are of the test runs, against the simulator's truth from contact forces; MAE and its standard
deviation. *Before* is the initial guess, against the model. *Expected* is the standard deviation
that the calibration itself states. What the *model alone* is off by, masses and encoders being what
they are, bounds what any calibration by moving can do; the scale's error is part of the GRF's.

{errors}

What the calibrations say of themselves:

{told}

A foot by itself is fixed weakly, as with the NAO ([trust](trust.md)).

## How they are simulated
As imperfect as the NAO of the other pages ([simulation](../reference/simulation.md)), in proportion: masses off
by 2 % each, a battery off its drawing, encoder zeros off by 1.5 mrad, a scale that errs by 0.4 %,
cells up to 30 % off with offsets; forces and stiffness grow with the weight. Six-axis sensors are
off by 5 %, with offsets of 0.1 % of their range, and ten times stiffer. Joints are finer than a
NAO's: 16 bits a turn instead of 12, 1 mrad of play instead of 4.5, a third of the give.

Motions are planned with the defaults but for `planning.cop_lean_weight`, 100 instead of none: the
paper's cost knows the CoP alone, and where hips turn far enough the torso may lean by more than 1
rad for it.

## What was not tried
None of these robots was there, and no maker's own calibration enters. One seed, so one simulated
robot of each kind. The robot is put into each double support, it does not step there. Nodes,
diagnosis and walking were not run on these robots. Drafted cells are guesses: whoever builds such
shoes has others.
"""


def robots_body(
    results: Sequence[Mapping[str, Any]], *, supports: int, train: int, seed: int
) -> str:
    """The section.

    Args:
        results: of each robot, in the order of the rows.
        supports, train: double supports, and how many of them train.
        seed: of robots, cells and noise.
    """
    done = [found for found in results if "failed" not in found]
    return TEXT.format(
        seed=seed,
        supports=supports,
        train=train,
        package=PACKAGE,
        version=version(),
        robots=_robots(done),
        errors=_errors(done),
        told="\n".join(_told(found) for found in results),
    )


def _robots(done: Sequence[Mapping[str, Any]]) -> str:
    """What they are, and how long it took."""
    rows = [[
        "robot", "mass (kg)", "CoM height (m)", "sole (mm)", "sensors", "in motion (s)",
        "processor: draft, simulation, fit (s)",
    ]]  # fmt: skip
    for found in done:
        kind = "a cell a corner" if not found["six_axis"] else (
            "six axes, named" if found["named"] else "six axes, `--six-axis`"
        )  # fmt: skip
        rows.append([
            found["title"],
            f"{found['mass_kg']:.1f}",
            f"{found['com_height_m']:.2f}",
            "{:.0f} × {:.0f}".format(*found["sole_mm"]),
            kind,
            f"{found['moving_s']:.0f}",
            ", ".join(f"{seconds:.0f}" for seconds in found["processor_s"].values()),
        ])  # fmt: skip
    return table(rows)


def _errors(done: Sequence[Mapping[str, Any]]) -> str:
    """What came out."""
    rows = [[
        "robot", "GRF (N)", "of the weight", "CoP before (mm)", "CoP (mm)", "expected",
        "model alone", "left CoP (mm)", "right CoP (mm)",
    ]]  # fmt: skip
    for found in done:
        truth = found["truth"]
        rows.append([
            found["title"],
            _error(truth, "grf", "n", 2),
            f"{truth['grf_mae_n'] / (GRAVITY * found['mass_kg']):.2%}",
            f"{found['before']['cop_mae_mm']:.0f}",
            _error(truth, "cop", "mm", 1),
            f"{found['expected']['both']['cop_std_mm']:.1f}",
            f"{found['model']['cop_mae_mm']:.1f}",
            _error(truth, "left_cop", "mm", 1),
            _error(truth, "right_cop", "mm", 1),
        ])  # fmt: skip
    return table(rows)


def _error(errors: Mapping[str, float], name: str, unit: str, digits: int) -> str:
    """MAE and standard deviation."""
    return f"{errors[f'{name}_mae_{unit}']:.{digits}f} ± {errors[f'{name}_std_{unit}']:.{digits}f}"


def _told(found: Mapping[str, Any]) -> str:
    """What a calibration said of itself, or why there is none."""
    if "failed" in found:
        return f"- {found['title']}: **not calibrated**: {found['failed']}."
    reasons = "; ".join(reason.partition(": ")[2] for reason in found["reasons"])
    said = f": {reasons}" if reasons else ", no warning"
    return f"- {found['title']}: {found['verdict']}{said}."
