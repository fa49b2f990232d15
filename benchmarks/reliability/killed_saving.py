"""A process that saves and applies calibrations is killed with SIGKILL at a random moment.

Each try is a forked process that in turns writes one calibration file again and puts a calibration
in force in the calibrator's store, the next one or, every third time, the one before. It is killed
a random while after a random one of these steps. No two of the calibrations have a gain or an
offset in common. What is loaded then, from the file and by the store, is what was there before the
step that was cut or after it, whole, to the last number, with the one before it to roll back to;
never an older one.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.child import Child, Steps
from reliability.row import Progress, Result, Row
from reliability.same import same
from reliability.tries import BrokenError, run_tries
from shoecal_core.estimation.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_ros.calibrator.calibration_store import CalibrationStore

MOST_STEPS = 6
LONGEST_S = 0.03
"""From one step to the kill; longer than a step takes."""
MADE = 100
"""More calibrations than are used until then."""

State = tuple[str, str, str]
"""Ids of the calibrations in the file, in force and before that; empty: none."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Save, apply, kill and load."""
    made = {one.id: one for one in map(made_from, range(MADE))}
    fresh = 0

    def attempt(_: int, rng: np.random.Generator) -> None:
        nonlocal fresh
        with tempfile.TemporaryDirectory(prefix="shoecal-killed-") as name:
            child = Child(partial(_change, Path(name), list(made.values())))
            child.wait(int(rng.integers(MOST_STEPS + 1)))
            time.sleep(rng.uniform(0.0, LONGEST_S))
            steps = child.kill()
            loaded = _load(Path(name), made)
        old, new = state_after(steps), state_after(steps + 1)
        if loaded not in (old, new):
            raise BrokenError(f"loaded {loaded}, expected {old} or {new}")
        fresh += loaded == new

    result = run_tries(attempt, first, count, seed, progress)
    kept = count - result.failed - fresh
    return replace(result, counts={"times the old one": kept, "times the new one": fresh})


def made_from(number: int) -> Calibration:
    """A calibration; its gains and offsets are drawn from its number."""
    rng, count = np.random.default_rng(number), len(originals.shoe().names)
    gains = np.sign(originals.calibration().parameters.gain) * rng.uniform(8.0, 15.0, count)
    numbers = ChannelParameters(gains, rng.uniform(-3.0, 3.0, count))
    # Small enough that a kill falls into any step of a change, not mostly into formatting numbers.
    small = replace(originals.calibration(), covariance=None, corrections=())
    return replace(small, id=f"made-{number}", parameters=numbers)


def name_of(loaded: Calibration | None, made: Mapping[str, Calibration]) -> str:
    """Id of a calibration that is whole; empty for none."""
    if loaded is None:
        return ""
    return loaded.id if same(loaded, made.get(loaded.id)) else f"{loaded.id} with other content"


def state_after(steps: int) -> State:
    """What is there after so many steps of `_change`."""
    saved, current, before = "", "", ""
    for step in range(steps):
        number = step // 2
        if step % 2 == 0:
            saved = f"made-{number}"
        else:
            current, before = (before if number % 3 == 2 else f"made-{number}"), current
    return saved, current, before


def _change(folder: Path, made: Sequence[Calibration], steps: Steps) -> None:
    """Save and apply one after the other until killed."""
    store = _store(folder)
    store.load(originals.START_NS)
    for number, calibration in enumerate(made):
        save_calibration(calibration, folder / "calibration.yaml")
        steps.value += 1
        applied = store.one_before()[0] if number % 3 == 2 else calibration
        store.apply(applied, originals.START_NS + number)
        steps.value += 1


def _load(folder: Path, made: Mapping[str, Calibration]) -> State:
    path, store = folder / "calibration.yaml", _store(folder)
    if problem := store.load(originals.START_NS):
        raise BrokenError(problem.message)
    saved = load_calibration(path) if path.exists() else None
    return name_of(saved, made), name_of(store.current, made), name_of(store.before, made)


def _store(folder: Path) -> CalibrationStore:
    return CalibrationStore(folder / "state", originals.robot(), originals.shoe())


ROW = Row(
    key="killed-saving",
    fault="kill -9 while saving or applying a calibration",
    holds="the old one or the new one, whole",
    tries=1_000,
    step=100,
    run=run,
)
