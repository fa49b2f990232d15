"""A process that saves or applies calibrations is killed with SIGKILL at a random moment.

Each try is a forked process that puts one calibration after the other in force in the calibrator's
store, and goes back now and then (every second try: that writes one calibration file again and
again). It is killed a random while after a random one of them. No two of the calibrations have a
gain or an offset in common. What is loaded then is what was in force before the change that was cut
or after it, whole, to the last number, with the one before it to roll back to; never an older one.
"""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from reliability import originals
from reliability.row import Progress, Result, Row
from reliability.same import same
from reliability.spawning import Child, Order, served
from shoecal_core.calibration.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.errors import ShoecalError
from shoecal_core.sensing.wrench import ChannelParameters
from shoecal_ros.calibrator.calibration_store import CalibrationStore

MOST_CHANGES = 3
LONGEST_S = 0.03
"""From one change to the kill; longer than a change takes."""
_FILE = "calibration.yaml"
_PATIENCE_S = 60.0

Pair = tuple[str, str]
"""In force, and before; empty: none."""
Made = Mapping[str, Calibration]
"""All that were made, by their ids."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    failed, fresh, worst = 0, 0, ""
    order = {"first": first, "count": count, "seed": seed}
    for done, one in enumerate(served("killed_saving", order), start=1):
        failed += bool(one["problem"])
        fresh += one["fresh"]
        worst = worst or one["problem"]
        progress(done)
    counts = {"times the old one": count - fresh, "times the new one": fresh}
    return Result(count, failed, worst, counts=counts)


def serve(order: Order) -> Iterator[dict[str, Any]]:
    """Fork, kill and load."""
    made = [made_from(number) for number in range(100)]
    for number in range(order["first"], order["first"] + order["count"]):
        rng = np.random.default_rng([order["seed"], number])
        with tempfile.TemporaryDirectory(prefix="shoecal-killed-") as name:
            folder = Path(name)
            work, found, pairs = (_store, _stored, _pairs()) if number % 2 else (
                _save, _saved, ((f"made-{count}", "") for count in itertools.count())
            )  # fmt: skip
            if number % 2 == 0:
                save_calibration(made[0], folder / _FILE)
            changes = _killed(partial(work, folder, made), rng)
            allowed = list(itertools.islice(pairs, changes, changes + 2))
            yield _verdict(partial(found, folder, {one.id: one for one in made}), allowed)


def made_from(number: int) -> Calibration:
    """A calibration; its gains and offsets are drawn from its number."""
    rng, count = np.random.default_rng(number), len(originals.shoe().names)
    numbers = ChannelParameters(rng.uniform(8.0, 15.0, count), rng.uniform(-3.0, 3.0, count))
    # Small enough that a kill falls into any step of a change, not mostly into formatting numbers.
    small = replace(originals.calibration(), covariance=None, corrections=())
    return replace(small, id=f"made-{number}", parameters=numbers)


def _killed(work: Callable[[Callable[[bytes], None]], None], rng: np.random.Generator) -> int:
    """Kill a process some while after some change; how many it has made."""
    child = Child(work)
    changes, while_s = int(rng.integers(MOST_CHANGES + 1)), rng.uniform(0.0, LONGEST_S)
    patience = time.monotonic() + _PATIENCE_S
    while len(child.told()) < changes and time.monotonic() < patience:
        time.sleep(0.0005)
    time.sleep(while_s)
    return len(child.kill())


def _verdict(found: Callable[[], Pair], allowed: list[Pair]) -> dict[str, Any]:
    try:
        pair = found()
    except ShoecalError as error:
        return {"problem": f"refused: {error}", "fresh": False}
    problem = "" if pair in allowed else f"loaded {pair}, expected one of {allowed}"
    return {"problem": problem, "fresh": pair == allowed[1]}


def _save(folder: Path, made: list[Calibration], tell: Callable[[bytes], None]) -> None:
    for calibration in made[1:]:
        save_calibration(calibration, folder / _FILE)
        tell(b".")


def _saved(folder: Path, made: Made) -> Pair:
    return name_of(load_calibration(folder / _FILE), made), ""


def _store(folder: Path, made: list[Calibration], tell: Callable[[bytes], None]) -> None:
    """Two applied, then one step back, and so on."""
    store = CalibrationStore(folder, originals.robot(), originals.shoe())
    store.load(originals.START_NS)
    for number, calibration in enumerate(made):
        applied = store.one_before()[0] if number % 3 == 2 else calibration
        store.apply(applied, originals.START_NS + number)
        tell(b".")


def _pairs() -> Iterator[Pair]:
    """What is in force after each change of `_store`."""
    current, before = "", ""
    for number in itertools.count():
        yield current, before
        current, before = (before if number % 3 == 2 else f"made-{number}"), current


def _stored(folder: Path, made: Made) -> Pair:
    store = CalibrationStore(folder, originals.robot(), originals.shoe())
    problem = store.load(originals.START_NS)
    if problem is not None:
        raise ShoecalError(problem.message)
    return name_of(store.current, made), name_of(store.before, made)


def name_of(loaded: Calibration | None, made: Made) -> str:
    """Id of a calibration that is whole; empty for none."""
    if loaded is None:
        return ""
    return loaded.id if same(loaded, made.get(loaded.id)) else f"{loaded.id} with other content"


ROW = Row(
    key="killed-saving",
    fault="kill -9 while saving or applying a calibration",
    holds="the old one or the new one, whole",
    tries=1_000,
    step=100,
    run=run,
)
