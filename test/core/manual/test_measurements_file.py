from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from core.manual.benches import (
    entry_of,
    nao_shoe,
    odd_shoe,
    read_cells,
    read_shoe,
    some_law,
)
from core.shoe import mutations
from core.shoe.mutations import DELETE, Key
from shoecal_core.errors import FileError, ShoecalError, VersionError
from shoecal_core.manual.loads import CELLS, SHOE, Load
from shoecal_core.manual.measurements import EntryError, LoadReading, Measurements
from shoecal_core.manual.measurements_file import load_measurements, save_measurements

READINGS = st.floats(-4.9, 4.9)


def some(kind: str) -> Measurements:
    shoe = nao_shoe()
    read = read_cells if kind == CELLS else read_shoe
    return read(shoe, some_law(shoe), (1.0, 2.0))


def same(one: Measurements, other: Measurements) -> None:
    assert one.kind == other.kind
    assert one.shoe.digest == other.shoe.digest
    for entry, again in zip(one.entries, other.entries, strict=True):
        assert (entry.load, entry.count, entry.made_ns) == (again.load, again.count, again.made_ns)
        np.testing.assert_array_equal(entry.mean, again.mean)
        np.testing.assert_array_equal(entry.std, again.std)


@given(st.data())
@settings(max_examples=40)
def test_everything_comes_back(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from([CELLS, SHOE]))
    whole = some(kind)
    loads = data.draw(st.lists(st.sampled_from(whole.entries), max_size=5, unique_by=id))
    entries = []
    for entry in loads:
        values = data.draw(st.lists(READINGS, min_size=4, max_size=4))
        spread = data.draw(st.lists(st.floats(0, 1) | st.just(np.nan), min_size=4, max_size=4))
        entries.append(
            LoadReading(
                entry.load,
                np.array(values),
                np.array(spread),
                data.draw(st.integers(1, 10**6)),
                data.draw(st.integers(0, 2**62)),
            )
        )
    measurements = Measurements(kind, whole.shoe, tuple(entries))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "data.yaml"
        save_measurements(measurements, path)
        found = load_measurements(path, kind, whole.shoe)
        assert found.path == path
        same(found, measurements)


def test_a_multimeter_and_an_editor_are_enough(tmp_path: Path) -> None:
    shoe = nao_shoe()
    path = tmp_path / "data.yaml"
    path.write_text(
        f"""
format: 1
kind: cells
shoe: nao_shoe
shoe_hash: {shoe.digest}
unit: V
entries:
  - {{cell: left/front_left, mass_kg: 0, mean: {{front_left: 0.25}}}}
  - {{cell: left/front_left, mass_kg: 2, mean: {{front_left: 1.75}}}}
"""
    )
    entry = load_measurements(path, CELLS, shoe).entries[1]
    assert entry.load == Load(0, "left/front_left", 2.0)
    assert entry.mean[0] == 1.75
    assert np.isnan(entry.mean[1:]).all()
    assert np.isnan(entry.std).all()
    assert (entry.count, entry.made_ns) == (1, 0)


def test_an_entry_takes_the_place_of_one_of_the_same_load() -> None:
    whole = some(SHOE)
    first, second, *_ = whole.entries
    only = Measurements(SHOE, whole.shoe).with_entry(first).with_entry(second)
    assert only.entries == (first, second)
    again = entry_of(whole.shoe, first.load, np.zeros(8))
    assert only.with_entry(again).entries == (again, second)
    assert only.entries == (first, second)


# ---- bad files --------------------------------------------------------------------------------

Edit = tuple[tuple[Key, ...], object]
BAD_SHOE: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "another kind": (("kind",), "cells", "kind", "holds readings of 'cells'"),
    "an unknown kind": (("kind",), "shoes", "kind", "not one of: cells, shoe"),
    "another shoe": (("shoe",), "slipper", "shoe", "readings of shoe 'slipper'"),
    "a shoe that was changed": (("shoe_hash",), "0" * 64, "shoe_hash", "has changed since"),
    "another unit": (("unit",), "mV", "unit", "readings in mV"),
    "no format": (("format",), DELETE, "format", "is missing"),
    "a key too many": (("colour",), "blue", "colour", "unknown key"),
    "entries that are none": (("entries",), 5, "entries", "expected a list"),
    "grams": (("entries", 1, "mass_kg"), 1500, "entries[1].mass_kg", "looks like grams"),
    "a weight below zero": (("entries", 1, "mass_kg"), -1, "entries[1].mass_kg", "no weight"),
    "no weight": (("entries", 1, "mass_kg"), 0, "entries[1].mass_kg", "without a weight"),
    "no hole": (("entries", 1, "hole"), DELETE, "entries[1].hole", "in which hole 1 kg stood"),
    "a hole too far": (("entries", 1, "hole"), "g1", "entries[1].hole", "a1 to f3"),
    "no foot": (("entries", 1, "foot"), DELETE, "entries[1].foot", "is missing"),
    "a third foot": (("entries", 1, "foot"), "middle", "entries[1].foot", "left, right"),
    "a cell in place of a hole": (
        ("entries", 1, "cell"), "left/front_left", "entries[1].cell", "unknown key"
    ),
    "an unknown cell": (
        ("entries", 1, "mean", "nose"), 1.0, "entries[1].mean.nose", "unknown key"
    ),
    "a missing reading": (
        ("entries", 1, "mean", "front_left"), DELETE, "entries[1].mean", "left/front_left is miss"
    ),
    "millivolts": (
        ("entries", 1, "mean", "front_left"), 873.0, "entries[1].mean", "in another unit"
    ),
    "the end of the range": (
        ("entries", 1, "mean", "front_left"), 5.0, "entries[1].mean", "end of its range"
    ),
    "a negative scatter": (
        ("entries", 1, "std", "front_left"), -1.0, "entries[1].count", "no negative std"
    ),
    "no samples": (("entries", 1, "count"), 0, "entries[1].count", "at least 1"),
    "a text": (("entries", 1, "mass_kg"), "one", "entries[1].mass_kg", "expected a number"),
}  # fmt: skip
BAD_CELLS: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "no such cell": (("entries", 1, "cell"), "left/nose", "entries[1].cell", "left/nose"),
    "no cell": (("entries", 1, "cell"), DELETE, "entries[1].cell", "is missing"),
    "a hole in place of a cell": (
        ("entries", 1, "hole"), "a1", "entries[1].hole", "unknown key"
    ),
    "its own reading missing": (
        ("entries", 0, "mean", "front_left"), DELETE, "entries[0].mean", "left/front_left is miss"
    ),
}  # fmt: skip


def check_refused(kind: str, edit: tuple[tuple[Key, ...], object, str, str], folder: Path) -> None:
    place, value, field, problem = edit
    good, bad = folder / "good.yaml", folder / "bad.yaml"
    save_measurements(some(kind), good)
    mutations.write_edited(bad, good, (place, value))
    error = mutations.refused(bad, lambda: load_measurements(bad, kind, nao_shoe()))
    assert error.field == field
    assert problem in error.problem


@pytest.mark.parametrize("name", BAD_SHOE)
def test_each_fault_is_one_error_that_names_its_field(name: str, tmp_path: Path) -> None:
    check_refused(SHOE, BAD_SHOE[name], tmp_path)


@pytest.mark.parametrize("name", BAD_CELLS)
def test_each_fault_of_cells_likewise(name: str, tmp_path: Path) -> None:
    check_refused(CELLS, BAD_CELLS[name], tmp_path)


def test_a_load_twice(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    save_measurements(some(SHOE), good)
    twice: Callable[[list[object]], list[object]] = lambda entries: [*entries, entries[2]]  # noqa: E731
    mutations.write_edited(bad, good, (("entries",), twice))
    error = mutations.refused(bad, lambda: load_measurements(bad, SHOE, nao_shoe()))
    assert "is in entries[2] already" in error.problem


def test_a_newer_format(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    save_measurements(some(SHOE), good)
    mutations.write_edited(bad, good, (("format",), 2))
    with pytest.raises(VersionError, match="update shoecal"):
        load_measurements(bad, SHOE, nao_shoe())


def test_readings_of_another_pair(tmp_path: Path) -> None:
    path = tmp_path / "data.yaml"
    save_measurements(some(SHOE), path)
    with pytest.raises(FileError, match=r"readings of shoe 'nao_shoe', but .* is 'odd_shoe'"):
        load_measurements(path, SHOE, odd_shoe(tmp_path))


def test_kinds_and_shapes_are_checked_without_a_file_too() -> None:
    whole = some(SHOE)
    with pytest.raises(ShoecalError, match="kind 'both' is not one of"):
        Measurements("both", whole.shoe)
    with pytest.raises(EntryError, match="no cell ''"):
        Measurements(CELLS, whole.shoe, whole.entries)
    short = LoadReading(whole.entries[0].load, np.zeros(3), np.zeros(3))
    with pytest.raises(ShoecalError, match=r"entries\[0\].mean: expected shape \(4,\)"):
        Measurements(SHOE, whole.shoe, (short,))


@given(st.data())
@settings(max_examples=60)
def test_whatever_happens_to_the_text_there_are_readings_or_one_error(data: st.DataObject) -> None:
    shoe = nao_shoe()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "data.yaml"
        few = some(SHOE)
        save_measurements(Measurements(SHOE, shoe, few.entries[:3]), path)
        text = data.draw(mutations.mutated(path.read_text()))
        path.write_text(text, encoding="utf-8")
        try:
            found = load_measurements(path, SHOE, shoe)
        except ShoecalError:
            return
    assert all(np.isfinite(entry.mean).all() for entry in found.entries)
    assert yaml.safe_load(text)["shoe_hash"] == shoe.digest
