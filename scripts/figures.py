"""Draw the figures of README, conventions and motions into docs/figures.

    .venv/bin/python scripts/figures.py [--session FOLDER]

`demo-run.svg` and `demo-expected.svg` are of the tutorial's session, which is simulated;
`conventions.svg` is of the NAO's files alone, `unload-left.svg` of a plan.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.files import atomic_write
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.assessment import error_pictures
from shoecal_core.report.calibration.content import CalibrationReport
from shoecal_core.report.calibration.figures import run_pictures
from shoecal_core.report.calibration.session_report import session_content
from shoecal_core.report.figures.feet import draw_feet, foot_shape
from shoecal_core.report.palette import INK, LEFT, RIGHT
from shoecal_core.report.sheet import SheetFigure, sheet, write_sheet
from shoecal_core.report.svg import SMALL, canvas
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot_file import load_robot, shoe_file_of
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workflows.calibrate import calibrate_session

ROOT = Path(__file__).resolve().parents[1]
ROBOT = ROOT / "config/robots/nao.yaml"
FIGURES = ROOT / "docs/figures"
TRAIN, TEST = (1, 2, 3), (4, 5)
SHOWN = 5
"""The run that is drawn: one that was not fitted."""
STANCE = DoubleSupport(0.04, -0.14, 0.35)
HEIGHT, MM = 300.0, 1e3
BELOW = (-54.0, -6.0)
"""mm, in its frame: where a sole bears its name."""


def main() -> None:
    """Draw all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, help="as the tutorial makes it (default: made)")
    args = parser.parse_args()
    write_conventions(FIGURES / "conventions.svg")
    with tempfile.TemporaryDirectory() as folder:
        write_unloading(FIGURES / "unload-left.svg", Path(folder) / "plan")
        session = args.session or simulated(Path(folder) / "session")
        content = calibrated(session)
        write_run(FIGURES / "demo-run.svg", content)
        write_expected(FIGURES / "demo-expected.svg", content)


def shoecal(*words: str | Path) -> None:
    """Run a command of it."""
    subprocess.run([sys.executable, "-m", "shoecal_core.cli", *map(str, words)], check=True)


def simulated(session: Path) -> Path:
    """The tutorial's recording."""
    shoecal("simulate", ROBOT, shoe_file_of(ROBOT), "--out", session)
    return session


def write_unloading(path: Path, plan: Path) -> None:
    """The left foot lifted for a moment, as it is planned."""
    shoecal("plan", ROBOT, "--motion", "unload_left", "--stance", "neutral", "--out", plan)
    atomic_write(path, (plan / "motion_001.svg").read_text())


def calibrated(folder: Path) -> CalibrationReport:
    """What a report tells of it."""
    session = Session.open(folder)
    settings, tolerances = CalibrationSettings(), Tolerances()
    outcome = calibrate_session(session, TRAIN, TEST, settings, tolerances)
    return session_content(session, outcome)


def write_run(path: Path, content: CalibrationReport) -> None:
    """CoP from above and against time, of one run."""
    (run,) = (one for one in content.runs if one.run == SHOWN)
    shown = {picture.title: picture for picture in run_pictures(content, run)}
    above, course = shown["CoP between the feet"], shown["CoP and GRF"]
    parts = [
        SheetFigure("CoP between the feet", above.svg),
        SheetFigure("CoP in the left sole's frame, and GRF", course.svg),
    ]
    write_sheet(
        path,
        [parts],
        "A simulated run that was not fitted. CoP from above and against time, and GRF: by the "
        "model, by the initial guess and by the calibrated cells, which lie on the model.",
    )


def write_expected(path: Path, content: CalibrationReport) -> None:
    """Maps of the expected error."""
    assert content.assessed is not None
    pictures = error_pictures(content, content.assessed)
    parts = [SheetFigure(picture.title, picture.svg) for picture in pictures]
    write_sheet(path, [parts], "Expected error of the CoP over the sensing polygons, as a map.")


def write_conventions(path: Path) -> None:
    """Both soles from above, their frames, and the double support between them."""
    shoe = load_shoe(shoe_file_of(ROBOT))
    robot = load_robot(ROBOT, shoe)
    feet = [foot_shape(robot, shoe, 0), foot_shape(robot, shoe, 1, STANCE)]
    with canvas(HEIGHT) as page:
        axes = page.panel(8.0, HEIGHT - 44.0, left=50.0)
        draw_feet(axes, feet, named=False)
        _frame(axes, np.zeros(2), 0.0, "l_sole", LEFT.light)
        _frame(axes, STANCE.translation, STANCE.dtheta, "r_sole", RIGHT.light)
        _support(axes)
        axes.set_aspect("equal")
        axes.set_xlim(90.0, -260.0)
        axes.set_ylim(-90.0, 190.0)
        axes.set_xlabel("y, to the left (mm)")
        axes.set_ylabel("x, forward (mm)")
        alt = "Frames of both soles from above; dx, dy and dtheta lead from the left to the right."
        drawn = page.svg(alt)
    atomic_write(
        path, sheet([[SheetFigure("From above: the robot looks up the page", drawn)]], alt)
    )


def _frame(axes: Axes, origin: np.ndarray, turn: float, name: str, colour: str) -> None:
    """Axes of a sole: x is drawn upwards, y to the left."""
    x, y = origin * MM
    for angle, label in ((turn, "x"), (turn + np.pi / 2, "y")):
        tip = (y + 60.0 * np.sin(angle), x + 60.0 * np.cos(angle))
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6}
        axes.annotate("", xy=tip, xytext=(y, x), arrowprops=arrow)
        axes.text(
            y + 70.0 * np.sin(angle), x + 70.0 * np.cos(angle), label,
            color=colour, ha="center", va="center",
        )  # fmt: skip
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    below_x, below_y = origin * MM + turned @ BELOW
    axes.text(below_y, below_x, name, color=colour, ha="left", va="top")


def _support(axes: Axes) -> None:
    """The way from the left sole to the right one."""
    x, y = STANCE.translation * MM
    both = {"arrowstyle": "<|-|>", "color": INK.light, "linewidth": 0.8}
    axes.annotate("", xy=(0.0, -78.0), xytext=(y, -78.0), arrowprops=both)
    axes.text(y / 2, -74.0, "dy < 0", ha="center", va="bottom", fontsize=SMALL)
    axes.annotate("", xy=(-215.0, 0.0), xytext=(-215.0, x), arrowprops=both)
    axes.text(-220.0, x / 2, "dx > 0", ha="left", va="center", fontsize=SMALL)
    for line in (([0.0, -220.0], [0.0, 0.0]), ([y, -220.0], [x, x]), ([0.0, 0.0], [0.0, -80.0])):
        axes.plot(*line, color=INK.light, linewidth=0.5, dashes=(4.0, 3.0))
    axes.plot([y, y], [x + 100.0, -80.0], color=INK.light, linewidth=0.5, dashes=(4.0, 3.0))
    degrees = np.degrees(STANCE.dtheta)
    axes.add_patch(Arc((y, x), 180.0, 180.0, theta1=90.0 - degrees, theta2=90.0, color=INK.light))
    axes.text(y + 4.0, x + 116.0, "dtheta > 0", ha="center", va="bottom", fontsize=SMALL)


if __name__ == "__main__":
    main()
