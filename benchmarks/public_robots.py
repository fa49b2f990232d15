"""Draft, plan, simulate and calibrate public humanoids; write docs/evidence/robots.md.

    make robots [ARGS="--only g1 --supports 5"]

Nothing of a robot is written by hand: its files are what `shoecal new robot` drafts from its URDF.
A robot whose result stands already is not run again.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from humanoids import HUMANOIDS, PACKAGE, Humanoid, descriptions
from pages import ROOT, markdown, write_section
from shoecal_core.recording.session import Session
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

PAGE = ROOT / "docs" / "evidence" / "robots.md"
TRAIN = 3


class CommandError(Exception):
    """What a command said as it failed."""


def main() -> int:
    """Run all, write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=[robot.name for robot in HUMANOIDS])
    parser.add_argument("--supports", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "robots")
    parser.add_argument("--doc", type=Path, default=PAGE)
    args = parser.parse_args()
    if args.supports <= TRAIN:
        parser.error(f"--supports: {TRAIN} train, so ask for at least {TRAIN + 1}")
    folder = descriptions()
    if folder is None:
        print(f"{PACKAGE} is not installed; make robots installs it", file=sys.stderr)
        return 1
    chosen = [robot for robot in HUMANOIDS if not args.only or robot.name in args.only]
    for robot in chosen:
        result = args.out / robot.name / "result.json"
        if not result.is_file():
            print(f"{robot.name} …", flush=True)
            try:
                found = run(robot, folder, args.out / robot.name, args.supports, args.seed)
            except CommandError as error:
                print(f"{robot.name}: {error}", flush=True)
                found = {"verdicts": {"robot": robot.title, "calibration": f"none: {error}"}}
            result.write_text(json.dumps(found, indent=1) + "\n")
    results = [
        json.loads(file.read_text())
        for robot in HUMANOIDS
        if (file := args.out / robot.name / "result.json").is_file()
    ]
    for name in ("robots", "errors", "verdicts"):
        rows = [found[name] for found in results if name in found]
        if rows:
            write_section(name, markdown(rows), args.doc)
    print(args.doc)
    return 0


def run(humanoid: Humanoid, folder: Path, out: Path, supports: int, seed: int) -> dict[str, object]:
    """From URDF to errors; its row of each table.

    Raises:
        CommandError: when one of the commands fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    robot_file, shoe_file = out / f"{humanoid.name}.yaml", out / f"{humanoid.name}_shoe.yaml"
    seconds = {"draft": -_processor_seconds()}
    drafted = shoecal(
        out / "draft.json", "new", "robot", folder / humanoid.urdf, "-o", robot_file,
        "--shoe", shoe_file, "--force", *(["--six-axis"] if humanoid.six_axis else []),
    )  # fmt: skip
    seconds["draft"] += _processor_seconds()
    shoe = load_shoe(shoe_file)
    robot = load_robot(robot_file, shoe)
    com_height = float(Kinematics(robot).states(robot.posture[None]).com[0, 0, 2])
    folder_of_runs = out / "session"
    seconds["simulation"] = -_processor_seconds()
    shoecal(
        out / "simulated.json", "simulate", robot_file, shoe_file, "--reality", drafted["reality"],
        "--supports", supports, "--seed", seed,
        "--out", folder_of_runs,
    )  # fmt: skip
    seconds["simulation"] += _processor_seconds()
    train = ",".join(str(number) for number in range(1, TRAIN + 1))
    test = ",".join(str(number) for number in range(TRAIN + 1, supports + 1))
    sets = ("--train", train, "--test", test)
    calibration = out / "calibration.yaml"
    seconds["fit"] = -_processor_seconds()
    fitted = shoecal(out / "fit.json", "calibrate", folder_of_runs, "--out", calibration, *sets)
    seconds["fit"] += _processor_seconds()
    judged = shoecal(
        out / "judged.json", "evaluate", folder_of_runs, "--calibration", calibration, *sets
    )
    session = Session.open(folder_of_runs)
    length, width = 1e3 * np.ptp(robot.feet[0].outline, axis=0)
    moving = sum(float(session.read(one.run).readings.time[-1]) for one in session.runs)
    sensors = "a cell a corner"
    if drafted["six_axis"]:
        sensors = "six axes, `--six-axis`" if humanoid.six_axis else "six axes, named"
    truth, expected = judged["against_truth"]["test"], fitted["assessment"]["expected_error"]
    before = fitted["against_model"]["initial_guess"]["test"]
    reasons = "; ".join(reason.partition(": ")[2] for reason in fitted["reasons"])
    return {
        "robots": {
            "robot": humanoid.title,
            "mass (kg)": f"{drafted['mass_kg']:.1f}",
            "CoM height (m)": f"{com_height:.2f}",
            "sole (mm)": f"{length:.0f} × {width:.0f}",
            "sensors": sensors,
            "in motion (s)": f"{moving:.0f}",
            "processor: draft, simulation, fit (s)": ", ".join(
                f"{used:.0f}" for used in seconds.values()
            ),
        },
        "errors": {
            "robot": humanoid.title,
            "GRF (N)": _error(truth, "grf", "n", 2),
            "of the weight": f"{truth['grf_mae_n'] / (GRAVITY * drafted['mass_kg']):.2%}",
            "CoP before (mm)": f"{before['cop_mae_mm']:.0f}",
            "CoP (mm)": _error(truth, "cop", "mm", 1),
            "expected": f"{expected['both']['cop_std_mm']:.1f}",
            "model alone": f"{judged['model']['against_truth']['test']['cop_mae_mm']:.1f}",
            "left CoP (mm)": _error(truth, "left_cop", "mm", 1),
            "right CoP (mm)": _error(truth, "right_cop", "mm", 1),
        },
        "verdicts": {
            "robot": humanoid.title,
            "calibration": f"{fitted['verdict']}: {reasons or 'no warning'}",
        },
    }


def _error(errors: Mapping[str, float], name: str, unit: str, digits: int) -> str:
    """MAE and standard deviation."""
    return f"{errors[f'{name}_mae_{unit}']:.{digits}f} ± {errors[f'{name}_std_{unit}']:.{digits}f}"


def _processor_seconds() -> float:
    """Of all commands run so far [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def shoecal(figures: Path, *words: object) -> dict[str, Any]:
    """Run a command; its figures.

    Raises:
        CommandError: with the first of the reasons that it gave.
    """
    command = [str(Path(sys.executable).with_name("shoecal")), *map(str, words)]
    log = figures.with_suffix(".log")
    with log.open("wb") as stream:
        done = subprocess.run(
            [*command, "--json", str(figures)], stdout=stream, stderr=stream, check=False
        )
    if done.returncode != 0:
        said = log.read_text().splitlines()[-1].partition(": ")[2]
        raise CommandError(said.replace(f"{ROOT}/", "").partition("; ")[0])
    found: dict[str, Any] = json.loads(figures.read_text())
    return found


if __name__ == "__main__":
    sys.exit(main())
