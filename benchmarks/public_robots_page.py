"""The tables of docs/evidence/robots.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from humanoids import PACKAGE, version
from pages import table
from shoecal_core.model.robot import GRAVITY

HEAD = """\
# Other robots

Public humanoid descriptions: drafted, planned, calibrated. **Everything here is simulated.** Step
by step: [your robot](../how-to/your-robot.md).
"""

TEXT = """\
## From a URDF to a calibration, nothing by hand
`make robots`: seed {seed}, {supports} double supports, the first {train} to train. Descriptions
come from the package `{package}` {version}, which the command installs. Robot and shoe files are
the unchanged drafts of `shoecal new robot`: masses as published, and a cell under each corner of
the sole if the ankles have no six-axis sensor.

{robots}

*Named*: the URDF has the sensors. *In motion*: all double supports. *Processor*: `new robot`,
`simulate` and `calibrate` on one core of the machine in [performance](performance.md).

Errors (MAE ± standard deviation) of test runs against contact forces; the GRF's include the
scale's. *Before*: initial guess against the model. *Expected*: as the calibration states. *Model
alone* bounds any calibration by moving.

{errors}

What the calibrations say of themselves:

{told}

Single feet are less accurate, as with the NAO ([accuracy](trust.md)).

## How they are simulated
As imperfect as the NAO ([simulation](../reference/simulation.md)) in proportion: masses 2 % off,
battery misplaced, encoder zeros 1.5 mrad, scale 0.4 %, cells up to 30 % with offsets; forces and
stiffness grow with the weight. Six-axis sensors: 5 %, offsets of 0.1 % of their range, ten times
stiffer. Joints are finer than a NAO's: 16 bits per turn instead of 12, 1 mrad of backlash instead
of 4.5, a third of the compliance.

Default planning, except `planning.cop_lean_weight` 100 instead of 0: otherwise the torso may lean
by more than 1 rad.

## What was not tried
No real robot and no manufacturer's calibration. One seed, so one simulated robot of each kind. The
robot is placed in each double support. No nodes, diagnosis or walking. Drafted cells are guesses.
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
