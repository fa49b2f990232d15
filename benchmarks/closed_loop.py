"""An effect is put into a robot, found, written into its files, and simulated again: what is left?

    .venv/bin/python benchmarks/closed_loop.py [--seeds 2] [--jobs 2]

By the commands `simulate`, `diagnose` and `correct`, on a robot that differs from its files by
this effect alone. What is left of the gap is measured on a run that neither diagnosis nor
calibration has used, with a motion that no other run has: between what was recorded and what the
simulated robot of the corrected files shows under the same commands, over the same for the files
as they were. What a URDF has no place for is taken from `randomisation.yaml`. Writes a table of
docs/evidence/diagnosis.md and the key `closed_loop` of out/bench.json.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pages import EVIDENCE, Row, markdown, record, write_section
from shoecal_core import cli
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.series import errors, measured_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import yaml_text
from shoecal_core.recording.session import Session
from shoecal_core.robot.randomisation import (
    COMPLIANCE,
    LATENCY,
    PLAY,
    Randomisation,
    load_randomisation,
)
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.replayed import Replayed, like_the_model, replay
from shoecal_core.workspace import config_dir

INJECTED: Sequence[Mapping[str, Any]] = (
    {"effect": "joint_offset", "location": ["LAnklePitch"], "angle_rad": 0.03},
    {"effect": "joint_offset", "location": ["RHipPitch"], "angle_rad": 0.03},
    {"effect": "payload", "location": ["LThigh_link"], "mass_kg": 0.5},
    {"effect": "payload", "location": ["Head_link"], "mass_kg": 0.5},
    {"effect": "joint_compliance", "location": ["all"], "compliance_rad_per_nm": 0.03},
    {"effect": "joint_compliance", "location": ["RKneePitch"], "compliance_rad_per_nm": 0.03},
    {"effect": "backlash", "location": ["all"], "play_rad": 0.03},
    {"effect": "latency", "location": ["left"], "delay_s": 0.15},
)
"""Of which `correct` has something to write; so large that the CoP is millimetres off. A shifted
CoM of the torso is none of them: gains make up for it, and the diagnosis says that it cannot be
seen."""
MOTIONS = (
    "landmarks", "reversed", "torso_height", "unload_left", "unload_right", "landmarks",
    "reversed", "faster",
)  # fmt: skip
"""The last is in no other run."""
TRAIN, TEST, UNUSED = (1, 2, 3, 4, 5, 6), 7, 8
SIMULATED = {
    COMPLIANCE: ("joint_compliance", "compliance_rad_per_nm"),
    PLAY: ("backlash", "play_rad"),
    LATENCY: ("latency", "delay_s"),
}
"""Effect and size of what no URDF has a place for."""
SETTINGS = CalibrationSettings()


class Outcome(NamedTuple):
    """What came of one effect.

    Attributes:
        effect: with its place. verdict, causes: of the diagnosis.
        before, after: CoP of the simulated robot off the recorded one [mm]; NaN without a cause.
    """

    effect: str
    seed: int
    verdict: str
    causes: str
    before: float
    after: float


def outcome(job: tuple[Mapping[str, object], int]) -> Outcome:
    """Simulate, diagnose, correct, simulate again."""
    effect, seed = job
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = _diagnosed(folder, effect, seed)
        made = _run(
            "correct", folder / "session", "--diagnosis", folder / "diagnosis.json",
            "--out", folder / "files",
        )  # fmt: skip
        before, after = _gaps(folder) if made else (np.nan, np.nan)
    causes = ", ".join(_text(one) for one in found["causes"]) or "none"
    return Outcome(_text(effect), seed, found["verdict"], causes, before, after)


def _text(cause: Mapping[str, Any]) -> str:
    places = cause["location"]
    return f"{cause['effect']} ({', '.join(places)})" if places else str(cause["effect"])


def _run(*words: object) -> bool:
    """Whether a command ends well."""
    with contextlib.redirect_stdout(sys.stderr):
        return cli.main([str(word) for word in words]) == 0


def _diagnosed(folder: Path, effect: Mapping[str, object], seed: int) -> Mapping[str, Any]:
    """What is said of a robot with an effect; session and answer stay in the folder."""
    perfect = (config_dir() / "realities" / "perfect.yaml").read_text()
    (folder / "reality.yaml").write_text(perfect + yaml_text({"effects": [dict(effect)]}))
    session, diagnosis = folder / "session", folder / "diagnosis.json"
    assert _run(
        "simulate", config_dir() / "robots" / "nao.yaml", config_dir() / "shoes" / "nao_shoe.yaml",
        "--reality", folder / "reality.yaml", "--supports", 5, "--rate", 50, "--seed", seed,
        "--motions", ",".join(MOTIONS), "--out", session,
    )  # fmt: skip
    assert _run(
        "diagnose", session, "--train", ",".join(map(str, TRAIN)), "--test", TEST,
        "--no-simulation", "--json", diagnosis,
    )  # fmt: skip
    found: Mapping[str, Any] = json.loads(diagnosis.read_text())
    return found


def _gaps(folder: Path) -> tuple[float, float]:
    """With the robot's files as they were and as corrected [mm]."""
    session, files, corrected = (folder / name for name in ("session", "files", "corrected"))
    shutil.copytree(session, corrected)
    for name in ("robot.yaml", "robot.urdf"):
        shutil.copy(files / name, corrected / name)
    # Its runs state the sum of the robot's files as they were.
    recorded = Session.open(corrected, force=True)
    calibration = calibrate_session(recorded, TRAIN, (), SETTINGS, Tolerances()).calibration
    sensing = calibration.sensing(recorded.shoe)
    stances = load_data(recorded, (UNUSED,), SETTINGS).of((UNUSED,))

    def gap(shown: Replayed) -> float:
        apart = []
        for one in stances:
            readings = [np.interp(one.time, shown.time, each) for each in shown.readings.T]
            simulated = replace(one, readings=np.stack(readings, axis=1))
            apart.append((measured_series(sensing, one), measured_series(sensing, simulated)))
        return 1e3 * errors(apart).cop.mean

    def simulated(robot_folder: Path, effects: Sequence[Effect]) -> Replayed:
        robot = load_robot(
            robot_folder / "robot.yaml", recorded.shoe, urdf=robot_folder / "robot.urdf"
        )
        drawn = like_the_model(robot, recorded.shoe, sensing.parameters, effects)
        return replay(recorded.read(UNUSED), robot, recorded.shoe, drawn, 0.0)

    found = effects_of(load_randomisation(files / "randomisation.yaml"), folder / "found.yaml")
    return gap(simulated(session, ())), gap(simulated(corrected, found))


def effects_of(found: Randomisation, file: Path) -> Sequence[Effect]:
    """What a URDF has no place for, written to a file of changes to the default reality."""
    effects = [
        {"effect": SIMULATED[one.kind][0], "location": [one.at], SIMULATED[one.kind][1]: one.mean}
        for one in found.parameters
        if one.kind in SIMULATED and one.mean > 0.0
    ]
    file.write_text(yaml_text({"format": 1, "name": "found", "effects": effects}))
    return load_reality(config_dir() / "realities" / "default.yaml", file).effects


def rows(outcomes: Sequence[Outcome]) -> Iterator[Row]:
    """One an effect and seed, and the median of what is left where a cause was named."""
    for one in outcomes:
        yield {
            "effect": one.effect,
            "seed": one.seed,
            "verdict": one.verdict,
            "causes": one.causes,
            "gap before [mm]": None if np.isnan(one.before) else one.before,
            "after [mm]": None if np.isnan(one.after) else one.after,
            "left": None if np.isnan(one.after) else f"{one.after / one.before:.0%}",
        }
    left = [one.after / one.before for one in outcomes if not np.isnan(one.after)]
    named = f"**corrected: {len(left)} of {len(outcomes)}; median**"
    median = f"**{np.median(left):.0%}**" if left else "-"
    yield {
        "effect": named, "seed": "", "verdict": "", "causes": "", "gap before [mm]": "",
        "after [mm]": "", "left": median,
    }  # fmt: skip


def main() -> None:
    """Every effect in every seed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args()
    jobs = itertools.product(INJECTED, range(1, args.seeds + 1))
    outcomes = []
    with ProcessPoolExecutor(args.jobs) as pool:
        for one in pool.map(outcome, jobs):
            outcomes.append(one)
            print(one, flush=True)
    record("closed_loop", [one._asdict() for one in outcomes if not np.isnan(one.after)])
    write_section("closed-loop", markdown(list(rows(outcomes))), EVIDENCE / "diagnosis.md")


if __name__ == "__main__":
    main()
