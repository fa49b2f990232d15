"""A recording, or a calibration, of another robot or another shoe.

One byte of the robot's file, its URDF or the shoe's file is altered, or the whole file is another
one's. A session whose run was recorded with the file as it was before refuses to read the run, and
says which file; the calibrator refuses a calibration made with it; each has a code of its own. Both
obey when forced, except that a calibration with other channels is never applied.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.row import Progress, Result, Row
from reliability.tries import BrokenError, run_tries
from shoecal_core.errors import FileError, ShoecalError, error_code
from shoecal_core.files import sha256
from shoecal_core.recording.session import ROBOT, SHOE, URDF, Session
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_ros.calibrator.calibration_store import CalibrationStore

OTHERS = {ROBOT: "robots/wren.yaml", URDF: "robots/wren.urdf", SHOE: "shoes/wren_shoe.yaml"}


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """A session and a calibration a try."""
    with tempfile.TemporaryDirectory(prefix="shoecal-other-") as name:
        whole = originals.session(Path(name) / "whole", runs=1, samples=5)

        def attempt(number: int, rng: np.random.Generator) -> None:
            folder = Path(name) / str(number)
            shutil.copytree(whole.folder, folder)
            _check_session(folder, rng)
            _check_calibration(rng)
            shutil.rmtree(folder)

        worst = "each refused, with the file's name and the code"
        return run_tries(attempt, first, count, seed, progress, worst)


def _check_session(folder: Path, rng: np.random.Generator) -> None:
    name = list(OTHERS)[rng.integers(len(OTHERS))]
    _alter(folder / name, rng)
    session = Session.open(folder)
    _check_refused(lambda: session.read(1), "hash-mismatch", name)
    try:
        load_shoe(folder / SHOE)
    except FileError as error:  # the altered byte made it no shoe at all
        if (code := error_code(type(error))) not in ("file-syntax", "field", "version"):
            raise BrokenError(f"refused with the code {code}: {error}") from error
        return
    try:
        Session.open(folder, force=True).read(1)
    except ShoecalError as error:
        if name != SHOE:
            raise BrokenError(f"forced, it is refused all the same: {error}") from error


def _check_calibration(rng: np.random.Generator) -> None:
    store = CalibrationStore(Path("nowhere"), originals.robot(), originals.shoe())
    made = originals.calibration()
    digest = rng.bytes(32).hex()
    others = replace(made, robot_hash=digest), replace(made, shoe_hash=digest)
    other = others[rng.integers(2)]
    _check_refused(lambda: store.check(other), "not-applicable")
    store.check(other, force=True)
    names = list(made.channels)
    rng.shuffle(names)
    if tuple(names) != made.channels:
        other = replace(made, channels=tuple(names))
        _check_refused(lambda: store.check(other, force=True), "wrong-shoe")


def _check_refused(use: Callable[[], object], code: str, text: str = "") -> None:
    """Check the code of a refusal, and that its message holds a text."""
    try:
        use()
    except ShoecalError as error:
        found = error_code(type(error))
        if found != code or text not in str(error):
            raise BrokenError(f"not {code} of {text or 'it'}, but {found}: {error}") from error
    else:
        raise BrokenError(f"not refused as {code} {text}")


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
