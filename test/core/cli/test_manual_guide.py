"""A guided session: the real command in a real terminal, the rig in the person's hands."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import Run
from core.cli.terminal import Terminal
from core.shoe import mutations, shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.manual.measurements_file import load_measurements
from shoecal_core.manual.settings import load_manual_settings
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.workflows.simulated_manual import rig_readings

CONFIG = shoes.ROOT / "config"
REALITY = load_reality(CONFIG / "realities" / "default.yaml")
SAMPLES = 10
ROWS, WEIGHTS = [0.06, 0.02, -0.02], [1.0, 4.0]
ByHand = Callable[[Sequence[object], str], tuple[int, str, str]]
ASKED = r"(\d+) of (\d+)  (.*), then Enter"


@dataclass(frozen=True)
class Bench:
    """A small shoe with nine holes, two weights, and the rig that holds it."""

    folder: Path
    shoe: Shoe
    rig: LoadingRig

    def words(self, kind: str, *more: object) -> list[object]:
        """A command."""
        files = {"--shoe": self.shoe.path, "--settings": self.folder / "manual.yaml"}
        return [
            "manual", kind, self.data(kind), "--out", self.out(kind),
            *(part for pair in files.items() for part in pair), *more,
        ]  # fmt: skip

    def data(self, kind: str) -> Path:
        return self.folder / f"{kind}_data.yaml"

    def out(self, kind: str) -> Path:
        return self.folder / ("cells.yaml" if kind == CELLS else "calibration.yaml")

    def plan(self, kind: str) -> tuple[Load, ...]:
        settings = load_manual_settings(self.folder / "manual.yaml")
        return planned_loads(kind, self.shoe, settings.weights(kind))

    def lines(self, load: Load, count: int = SAMPLES) -> list[str]:
        """What a driver would say under a load."""
        return [self.line(row) for row in rig_readings(self.rig, load, count).voltages]

    def line(self, readings: FloatArray) -> str:
        return json.dumps(
            {"stamp_ns": 5, "cells": list(self.shoe.names), "voltages": readings.tolist()}
        )


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    path = tmp_path / "shoe.yaml"
    edits = [(("feet", foot, "holes", "x_m"), ROWS) for foot in FEET]
    shoe = load_shoe(mutations.write_edited(path, shoes.FILES["nao_shoe"], *edits))
    mutations.write_edited(
        tmp_path / "manual.yaml",
        CONFIG / "manual.yaml",
        (("shoe_weights_kg",), WEIGHTS),
        (("cell_weights_kg",), [2.0]),
        (("samples",), SAMPLES),
        (("patience_samples",), 3 * SAMPLES),
    )
    rng = np.random.default_rng(1)
    return Bench(tmp_path, shoe, LoadingRig(shoe, REALITY, draw_shoes(REALITY, shoe, 1), rng))


@pytest.fixture
def by_hand(shoecal: Run, monkeypatch: pytest.MonkeyPatch) -> ByHand:
    """Runs a command whose keys come from a pipe."""

    def run(words: Sequence[object], keys: str) -> tuple[int, str, str]:
        reading, writing = os.pipe()
        os.write(writing, keys.encode())
        os.close(writing)
        with os.fdopen(reading) as keyboard, monkeypatch.context() as patch:
            patch.setattr(sys, "stdin", keyboard)
            return shoecal(*words)

    return run


class Person:
    """Sits at the terminal, puts weights where it says, and lets the readings flow."""

    def __init__(self, bench: Bench, kind: str, terminal: Terminal, pipe: int) -> None:
        self.bench = bench
        self.plan = bench.plan(kind)
        self.terminal = terminal
        self._pipe = pipe

    def asked(self) -> int:
        """Number of the load that is asked for next."""
        found = self.terminal.until(ASKED)
        assert int(found[2]) == len(self.plan)
        load = self.plan[int(found[1]) - 1]
        place = load.place or ("nothing on it" if not load.mass else "")
        assert place in found[3]
        assert not load.mass or f"{load.mass:g} kg" in found[3]
        return int(found[1])

    def read(self, load: Load) -> None:
        """Press Enter, then readings under a load."""
        self.terminal.press("\n")
        self.terminal.until("reading: hold still")
        self.send(self.bench.lines(load))

    def send(self, lines: Sequence[str]) -> None:
        os.write(self._pipe, "".join(f"{line}\n" for line in lines).encode())


@pytest.fixture
def pipe(bench: Bench) -> Iterator[int]:
    """The writing end of a pipe with readings, `bench.folder / "readings"`."""
    os.mkfifo(bench.folder / "readings")
    descriptor = os.open(bench.folder / "readings", os.O_RDWR)
    yield descriptor
    os.close(descriptor)


def solve_cells(bench: Bench, by_hand: ByHand) -> None:
    """The first step, from a recording."""
    recording = bench.folder / "recording.jsonl"
    lines = [line for load in bench.plan(CELLS) for line in bench.lines(load)]
    recording.write_text("\n".join(lines))
    code, _, error = by_hand(bench.words(CELLS, "--from", recording), "\n" * 16)
    assert code == 0, error
    assert load_calibration(bench.out(CELLS)).source == "manual"


def test_a_session_at_a_terminal(bench: Bench, pipe: int, by_hand: ByHand) -> None:
    """Begun, stopped, taken up again, solved."""
    solve_cells(bench, by_hand)
    words = bench.words(SHOE, "--from", bench.folder / "readings")
    with Terminal(words) as terminal:
        _begin(Person(bench, SHOE, terminal, pipe))
        assert terminal.wait() == 1
        assert "stopped with 35 of 38 loads left; the same command goes on" in terminal.seen
        assert terminal.attributes == terminal.before
    assert len(load_measurements(bench.data(SHOE), SHOE, bench.shoe).entries) == 3
    assert not bench.out(SHOE).exists()
    with Terminal(words) as terminal:
        person = Person(bench, SHOE, terminal, pipe)
        for number in range(4, 39):
            assert person.asked() == number
            person.read(person.plan[number - 1])
        assert terminal.wait() == 0, terminal.seen
        assert "PASS: every check passed" in terminal.seen
    entries = load_measurements(bench.data(SHOE), SHOE, bench.shoe).entries
    assert {entry.load for entry in entries} == set(bench.plan(SHOE))
    assert {(entry.count, entry.made_ns) for entry in entries} == {(SAMPLES, 5)}
    found = load_calibration(bench.out(SHOE))
    true = draw_shoes(REALITY, bench.shoe, 1).parameters
    np.testing.assert_allclose(found.parameters.gain, true.gain, rtol=2e-3)


def _begin(person: Person) -> None:
    """Moved, wrong weight, repeat, back, skip, stop."""
    terminal, bench = person.terminal, person.bench
    assert person.asked() == 1
    person.read(person.plan[0])
    terminal.until(r"read: left shoe \S+ N")
    assert person.asked() == 2
    # A hand on the weight: the reading swings.
    terminal.press("\n")
    terminal.until("reading: hold still")
    rows = rig_readings(bench.rig, person.plan[1], 3 * SAMPLES).voltages
    person.send([bench.line(row + 0.1 * (index % 2)) for index, row in enumerate(rows)])
    terminal.until("moved while reading: again")
    assert person.asked() == 2
    # Another weight than was asked for.
    person.read(Load(0, "a1", 4.0))
    terminal.until(r"left shoe, 1 kg in hole a1: weighs 4\.0\d kg")
    assert person.asked() == 2
    person.read(person.plan[1])
    assert person.asked() == 3
    for key, number in (("r", 2), ("s", 3), ("b", 2)):
        terminal.press(key)
        assert person.asked() == number
    person.read(person.plan[1])
    assert person.asked() == 3
    person.read(person.plan[2])
    assert person.asked() == 4
    terminal.press("q")


@pytest.mark.parametrize("how", ["interrupted", "killed"])
def test_a_session_that_breaks_off_loses_nothing(bench: Bench, pipe: int, how: str) -> None:
    words = bench.words(CELLS, "--from", bench.folder / "readings", "--foot", "left")
    plan = [load for load in bench.plan(CELLS) if load.foot == 0]
    with Terminal(words) as terminal:
        person = Person(bench, CELLS, terminal, pipe)
        person.plan = tuple(plan)
        for number in range(1, 4):
            assert person.asked() == number
            person.read(plan[number - 1])
        assert person.asked() == 4
        terminal.press("\n")
        terminal.until("reading: hold still")
        person.send(bench.lines(plan[3], SAMPLES // 2))
        if how == "interrupted":
            terminal.press("\x03")
            assert terminal.wait() == 130
            assert terminal.attributes == terminal.before
        else:
            terminal.process.kill()
            terminal.wait()
    found = load_measurements(bench.data(CELLS), CELLS, bench.shoe)
    assert [entry.load for entry in found.entries] == plan[:3]
    assert not [path for path in bench.folder.iterdir() if path.name.startswith(".")]


# ---- without a terminal -----------------------------------------------------------------------


def recording(bench: Bench, loads: Sequence[Load]) -> Path:
    path = bench.folder / "recording.jsonl"
    path.write_text("\n".join(line for load in loads for line in bench.lines(load)) + "\n")
    return path


def test_a_recording_that_ends_too_early(bench: Bench, by_hand: ByHand) -> None:
    plan = bench.plan(CELLS)
    words = bench.words(CELLS, "--from", recording(bench, plan[:5]))
    code, _, error = by_hand(words, "\n" * 16)
    assert code == 1
    assert error.count("\n") == 1
    assert "recording.jsonl: has no more readings; what was read is kept" in error
    assert len(load_measurements(bench.data(CELLS), CELLS, bench.shoe).entries) == 5
    # Another file goes on.
    code, _, error = by_hand(bench.words(CELLS, "--from", recording(bench, plan[5:])), "\n" * 16)
    assert code == 0, error


def test_keys_that_end_too_early(bench: Bench, by_hand: ByHand) -> None:
    words = bench.words(CELLS, "--from", recording(bench, bench.plan(CELLS)))
    code, out, error = by_hand(words, "\n\n\n")
    assert code == 1
    assert "stopped with 13 of 16 loads left" in error
    assert "4 of 16  left/front_right, off its shoe: let it bear 2 kg, then Enter" in out


def test_csv_of_one_shoe(bench: Bench, by_hand: ByHand) -> None:
    """A logger of the left shoe alone."""
    plan = [load for load in bench.plan(CELLS) if load.foot == 0]
    names = bench.shoe.names[:4]
    rows = [
        ["9", *(f"{value:.6f}" for value in row[:4])]
        for load in plan
        for row in rig_readings(bench.rig, load, SAMPLES).voltages
    ]
    path = bench.folder / "log.csv"
    path.write_text("\n".join(map(",".join, [["stamp_ns", *names], *rows])))
    code, _, error = by_hand(bench.words(CELLS, "--from", path, "--foot", "left"), "\n" * 8)
    # One shoe is read, and calibrated without the other.
    assert code == 0, error
    assert load_calibration(bench.folder / "cells.yaml").channels == names
    code, _, error = by_hand(bench.words(CELLS), "")
    assert code == 1
    assert "no readings of right/front_left" in error
    entries = load_measurements(bench.data(CELLS), CELLS, bench.shoe).entries
    assert [entry.load for entry in entries] == plan
    assert entries[0].made_ns == 9


def test_null_fault_and_saturation(bench: Bench, by_hand: ByHand) -> None:
    load = bench.plan(CELLS)[0]
    good = json.loads(bench.lines(load, 1)[0])
    gone = {**good, "voltages": [None, *good["voltages"][1:]]}
    faulty = {**good, "status": [3] + [0] * 7}
    ends = {**good, "voltages": [5.0, *good["voltages"][1:]], "status": [1] + [0] * 7}
    path = bench.folder / "lines"
    for line, problem in (
        (gone, "not all cells gave readings"),
        (faulty, "not all cells gave readings"),
        (ends, "left/front_left is at the end of its range"),
    ):
        path.write_text("\n".join([json.dumps(line)] * 3 * SAMPLES))
        _, out, _ = by_hand(bench.words(CELLS, "--from", path), "\nq")
        assert problem in out
        assert not bench.data(CELLS).exists()
