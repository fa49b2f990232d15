"""Draft, plan, simulate and calibrate public humanoids; write the table of docs/robots.md.

    make robots [ARGS="--only g1 --supports 5"]

Nothing of a robot is written by hand: its files are what `shoecal new robot` drafts from its URDF.
A robot whose result stands already is not run again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from humanoids import HUMANOIDS, PACKAGE, Humanoid, descriptions, scaled_reality, version
from pages import ROOT, table, write_section
from shoecal_core.files import write_yaml
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.model.robot_file import load_robot
from shoecal_core.sensing.shoe import load_shoe

PAGE = ROOT / "docs" / "robots.md"
HEAD = """\
# Public humanoids

Humanoids of other makers, from descriptions that are public: drafted, planned, calibrated.
**Everything here is simulated.**
"""
TRAIN = 3


class CommandError(Exception):
    """What a command said as it failed."""


def main() -> int:
    """Run all, write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=[robot.name for robot in HUMANOIDS])
    parser.add_argument("--supports", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "robots")
    parser.add_argument("--doc", type=Path, default=PAGE)
    args = parser.parse_args()
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
                found = {"title": robot.title, "failed": str(error)}
            result.write_text(json.dumps(found, indent=1) + "\n")
    results = {
        robot.name: json.loads(file.read_text())
        for robot in HUMANOIDS
        if (file := args.out / robot.name / "result.json").is_file()
    }
    write_section("robots", page(results), args.doc, HEAD)
    print(args.doc)
    return 0


def run(humanoid: Humanoid, folder: Path, out: Path, supports: int, seed: int) -> dict[str, object]:
    """From URDF to errors; the figures of one row."""
    out.mkdir(parents=True, exist_ok=True)
    robot_file, shoe_file = out / f"{humanoid.name}.yaml", out / f"{humanoid.name}_shoe.yaml"
    drafted = shoecal(
        out / "draft.json", "new", "robot", folder / humanoid.urdf, "-o", robot_file,
        "--shoe", shoe_file, "--force", *(["--six-axis"] if humanoid.six_axis else []),
    )  # fmt: skip
    shoe = load_shoe(shoe_file)
    robot = load_robot(robot_file, shoe)
    com_height = float(Kinematics(robot).states(robot.posture[None]).com[0, 0, 2])
    reality = out / "reality.yaml"
    write_yaml(reality, scaled_reality(robot, shoe, com_height))
    session = out / "session"
    begin = time.monotonic()
    if not (session / "session.yaml").is_file():
        shoecal(
            out / "simulated.json", "simulate", robot_file, shoe_file, "--reality", reality,
            "--supports", supports, "--seed", seed, "--out", session,
        )  # fmt: skip
    seconds = time.monotonic() - begin
    train = ",".join(str(number) for number in range(1, TRAIN + 1))
    test = ",".join(str(number) for number in range(TRAIN + 1, supports + 1))
    sets = ("--train", train, "--test", test)
    calibration = out / "calibration.yaml"
    fitted = shoecal(out / "fit.json", "calibrate", session, "--out", calibration, *sets)
    judged = shoecal(out / "judged.json", "evaluate", session, "--calibration", calibration, *sets)
    length, width = np.ptp(robot.feet[0].outline, axis=0)
    return {
        "title": humanoid.title,
        "mass_kg": drafted["mass_kg"],
        "com_height_m": com_height,
        "sole_mm": [1e3 * float(length), 1e3 * float(width)],
        "motors": len(robot.legs),
        "six_axis": drafted["six_axis"],
        "named": drafted["six_axis"] and not humanoid.six_axis,
        "truth": judged["against_truth"]["test"],
        "modelled": judged["against_modelled"]["test"],
        "model": judged["model"]["against_truth"]["test"],
        "verdict": fitted["verdict"],
        "seconds": seconds,
    }


def shoecal(figures: Path, *words: object) -> dict[str, Any]:
    """Run a command; its figures."""
    command = [str(Path(sys.executable).with_name("shoecal")), *map(str, words)]
    log = figures.with_suffix(".log")
    with log.open("wb") as stream:
        done = subprocess.run(
            [*command, "--json", str(figures)], stdout=stream, stderr=stream, check=False
        )
    if done.returncode != 0:
        raise CommandError(log.read_text().splitlines()[-1])
    found: dict[str, Any] = json.loads(figures.read_text())
    return found


def page(results: Mapping[str, Mapping[str, Any]]) -> str:
    """The section."""
    rows = [
        ["robot", "mass (kg)", "sole (mm)", "sensors", "GRF (N)", "of the weight",
         "CoP (mm)", "model's own CoP (mm)", "each foot's CoP (mm)"],
    ]  # fmt: skip
    done = [found for found in results.values() if "failed" not in found]
    for found in done:
        truth, model = found["truth"], found["model"]
        kind = "four cells a foot" if not found["six_axis"] else (
            "six axes, named in the URDF" if found["named"] else "six axes, `--six-axis`"
        )  # fmt: skip
        share = truth["grf_mae_n"] / (9.80665 * found["mass_kg"])
        rows.append([
            found["title"],
            f"{found['mass_kg']:.1f}",
            "{:.0f} × {:.0f}".format(*found["sole_mm"]),
            kind,
            f"{truth['grf_mae_n']:.2f} ± {truth['grf_std_n']:.2f}",
            f"{share:.2%}",
            f"{truth['cop_mae_mm']:.1f} ± {truth['cop_std_mm']:.1f}",
            f"{model['cop_mae_mm']:.1f}",
            f"{truth['left_cop_mae_mm']:.1f}, {truth['right_cop_mae_mm']:.1f}",
        ])  # fmt: skip
    told = "".join(
        f"- **{found['title']}**, not calibrated: {found['failed'].replace(f'{ROOT}/', '')}.\n"
        for found in results.values()
        if "failed" in found
    )
    return TEXT.format(
        table=table(rows), failed=told, package=PACKAGE, version=version(), train=TRAIN
    )


TEXT = """\
## From a URDF to a calibration, nothing by hand
Made by `make robots`, one seed, five double supports of which the first {train} train. The
descriptions are those of the package `{package}` {version}, which the command installs; none of
them is part of this project. Robot file and shoe file of each are what `shoecal new robot` drafts,
unchanged: soles from the feet's meshes, the masses as published. No robot's own calibration enters,
and none of these robots was there.

Simulated are robots as imperfect as the NAO of the other pages ([simulation](simulation.md)):
masses off by 2 % each, a scale that errs by 0.4 %, cells up to 30 % off with offsets (six-axis
sensors: 5 %, and ten times stiffer); forces and stiffness grow with the robot. Gears are finer: 1
mrad of play instead of 4.5, a third of the give. Errors are of both test runs, against the
simulator's truth from contact forces; MAE and its standard deviation. What the model itself is
off by, masses and encoders being what they are, bounds what any calibration by moving can do.

{table}
{failed}
The scale's error is part of the GRF's. A foot by itself is fixed weakly, as with the NAO
([trust](trust.md)).
"""


if __name__ == "__main__":
    sys.exit(main())
