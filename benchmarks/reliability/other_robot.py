"""A recording, or a calibration, of another robot or another shoe.

One byte of the robot's file, its URDF or the shoe's file is altered, or the whole file is another
one's. A session whose run was recorded with the file as it was before refuses to read the run, and
says which file; the calibrator refuses a calibration made with it; each has a code of its own. Both
do as they are told when forced, except that a calibration with other channels is never applied.
"""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.row import Progress, Result, Row
from shoecal_core.errors import FileError, ShoecalError, error_code
from shoecal_core.files import sha256
from shoecal_core.recording.session import ROBOT, SHOE, URDF, Session
from shoecal_core.sensing.shoe import load_shoe
from shoecal_ros.calibrator.calibration_store import CalibrationStore

FILES = (ROBOT, URDF, SHOE)
OTHERS = {ROBOT: "robots/wren.yaml", URDF: "robots/wren.urdf", SHOE: "shoes/wren_shoe.yaml"}


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    failed, worst = 0, ""
    with tempfile.TemporaryDirectory(prefix="shoecal-other-") as name:
        whole = originals.session(Path(name) / "whole", runs=1, samples=5)
        for number in range(first, first + count):
            rng = np.random.default_rng([seed, number])
            folder = Path(name) / "session"
            shutil.copytree(whole.folder, folder)
            problem = _session_problem(folder, rng) or _calibration_problem(rng)
            failed += bool(problem)
            worst = worst or (problem and f"try {number}: {problem}")
            shutil.rmtree(folder)
            progress(number - first + 1)
    return Result(count, failed, worst or "each refused, with the file's name and the code")


def _session_problem(folder: Path, rng: np.random.Generator) -> str:
    """What is wrong with how a run of other files is taken; empty where nothing is."""
    name = FILES[int(rng.integers(len(FILES)))]
    _alter(folder / name, rng)
    session = Session.open(folder)
    for read in (session.check_hashes, lambda: session.read(1)):
        try:
            read()
        except ShoecalError as error:
            if wrong := _wrong_code(error, "hash-mismatch"):
                return wrong
            if name not in str(error):
                return f"another {name}, and the message does not say so: {error}"
        else:
            return f"a run recorded with another {name} was read"
    try:
        load_shoe(folder / SHOE)
    except FileError as error:  # the altered byte made it no shoe at all
        return _wrong_code(error, "file-syntax", "field", "version")
    try:
        Session.open(folder, force=True).read(1)
    except ShoecalError as error:
        if name != SHOE:
            return f"forced, it is refused all the same: {error}"
    return ""


def _calibration_problem(rng: np.random.Generator) -> str:
    """Likewise for a calibration in the calibrator's hands."""
    store = CalibrationStore(Path("nowhere"), originals.robot(), originals.shoe())
    made = originals.calibration()
    kind = str(rng.choice(["robot", "shoe"]))
    wrong = rng.bytes(32).hex()
    other = replace(made, robot_hash=wrong) if kind == "robot" else replace(made, shoe_hash=wrong)
    try:
        store.check(other)
    except ShoecalError as error:
        if wrong_code := _wrong_code(error, "not-applicable"):
            return wrong_code
        store.check(other, force=True)
    else:
        return f"a calibration of another {kind} is applied"
    names = list(made.channels)
    rng.shuffle(names)
    if tuple(names) != made.channels:
        try:
            store.check(replace(made, channels=tuple(names)), force=True)
        except ShoecalError as error:
            return _wrong_code(error, "wrong-shoe")
        return "a calibration of other channels is applied"
    return ""


def _wrong_code(error: ShoecalError, *codes: str) -> str:
    """What is wrong with the code of a refusal; empty where it is one of these."""
    found = error_code(type(error))
    return "" if found in codes else f"refused with the code {found}: {error}"


def _alter(path: Path, rng: np.random.Generator) -> None:
    """One byte, or the whole file."""
    before = sha256(path)
    if rng.random() < 0.5:
        data = bytearray(path.read_bytes())
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(7))
        path.write_bytes(data)
    else:
        shutil.copy(originals.CONFIG / OTHERS[path.name], path)
    assert sha256(path) != before


ROW = Row(
    key="other-robot",
    fault="a recording or a calibration of another robot or shoe",
    holds="refused with its own code, unless forced",
    tries=300,
    step=100,
    run=run,
)
