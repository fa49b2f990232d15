"""Shoes as data: what a file says, and what is refused."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from core.shoe import mutations, shoes
from core.shoe.mutations import DELETE, Key
from shoecal_core.errors import NameNotFoundError, ShoecalError, VersionError
from shoecal_core.files import sha256, write_yaml
from shoecal_core.shoe.shoe import AXES, FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe

SIX_AXIS = """
format: 1
name: ankles
unit: N
height_m: 0
converter: {lowest: -500, highest: 500}
feet:
  left: &foot
    plates: {mass_above_kg: 0, com_above_m: [0, 0, 0], mass_below_kg: 0.1, com_below_m: [0, 0, 0]}
    six_axis:
      origin_m: [0.01, -0.02, 0.09]
      axes: [{axis: fx}, {axis: fy}, {axis: fz}, {axis: mx, nominal_gain: -2.0}, {axis: my}]
  right: *foot
"""


@pytest.fixture
def six_axis(tmp_path: Path) -> Path:
    """A file of feet with six-axis sensors."""
    path = tmp_path / "six.yaml"
    write_yaml(path, yaml.safe_load(SIX_AXIS))
    return path


def test_the_file_is_what_the_shoe_is(shoe: Shoe) -> None:
    path = shoes.FILES[shoe.name]
    raw = yaml.safe_load(path.read_text())
    assert (shoe.name, shoe.unit, shoe.height) == (raw["name"], raw["unit"], raw["height_m"])
    assert shoe.digest == sha256(path)
    at = 0
    for index, foot in enumerate(FEET):
        cells = raw["feet"][foot]["cells"]
        assert shoe.of_foot(index).tolist() == list(range(at, at + len(cells)))
        for cell in cells:
            x, y = cell["position_m"]
            assert shoe.names[at] == f"{foot}/{cell['name']}"
            assert shoe.index(shoe.names[at]) == at
            np.testing.assert_array_equal(shoe.columns[at], [1.0, y, -x])
            np.testing.assert_array_equal(shoe.positions[at], [x, y])
            assert shoe.polarity[at] == cell["polarity"]
            at += 1
        plates = raw["feet"][foot]["plates"]
        assert shoe.plates[index].mass_below == plates["mass_below_kg"]
        np.testing.assert_array_equal(shoe.plates[index].com_above, plates["com_above_m"])
    assert len(shoe.channels) == at
    assert not shoe.torque.any()
    masses = [raw["feet"][foot]["plates"] for foot in FEET]
    assert shoe.mass == pytest.approx(sum(m["mass_above_kg"] + m["mass_below_kg"] for m in masses))


def test_channels_that_are_not_there(shoe: Shoe) -> None:
    with pytest.raises(NameNotFoundError, match="no channel named 'left/nose'") as caught:
        shoe.index("left/nose")
    assert caught.value.available == shoe.names


def test_six_axis_feet(six_axis: Path) -> None:
    shoe = load_shoe(six_axis)
    assert shoe.names == tuple(f"{foot}/{axis}" for foot in FEET for axis in AXES)
    assert shoe.torque.tolist() == [False, False, False, True, True] * 2
    assert shoe.polarity.tolist() == [0] * 10
    np.testing.assert_allclose(
        shoe.columns[:5],
        np.array([[0, 0, 0.09], [0, -0.09, 0], [1, -0.02, -0.01], [0, 1, 0], [0, 0, 1]]),
    )
    gains = [channel.nominal_gain for channel in shoe.channels]
    assert gains == [None, None, None, -2.0, None] * 2


def test_cells_beside_some_axes(tmp_path: Path) -> None:
    path = tmp_path / "mixed.yaml"
    foot = "feet", "left"
    axes = {"origin_m": [0, 0, 0.05], "axes": [{"axis": "fx"}, {"axis": "fy"}]}
    mutations.write_edited(path, shoes.FILES["odd_shoe"], ((*foot, "six_axis"), axes))
    assert load_shoe(path).names[:5] == (
        "left/toe", "left/heel_left", "left/heel_right", "left/fx", "left/fy",
    )  # fmt: skip


# ---- bad files --------------------------------------------------------------------------------

LEFT: tuple[Key, ...] = ("feet", "left")
CELL: tuple[Key, ...] = (*LEFT, "cells", 1)
PLATES: tuple[Key, ...] = (*LEFT, "plates")
BAD: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "no name": (("name",), DELETE, "name", "is missing"),
    "a number for a name": (("name",), 5, "name", "expected text"),
    "no unit": (("unit",), DELETE, "unit", "is missing"),
    "no format": (("format",), DELETE, "format", "is missing"),
    "a key too many": (("colour",), "blue", "colour", "unknown key"),
    "no height": (("height_m",), DELETE, "height_m", "is missing"),
    "a height in millimetres": (("height_m",), 22, "height_m", "at most 1"),
    "a height below the floor": (("height_m",), -0.01, "height_m", "at least 0"),
    "no converter": (("converter",), DELETE, "converter", "is missing"),
    "a converter that is a number": (("converter",), 5, "converter", "mapping"),
    "a misspelt converter": (("converter", "highst"), 5, "converter.highst", "unknown key"),
    "a crossed converter": (("converter", "highest"), -5.0, "converter.lowest", "below"),
    "an infinite converter": (("converter", "highest"), math.inf, "converter.highest", "finite"),
    "no right foot": (("feet", "right"), DELETE, "feet.right", "is missing"),
    "three feet": (("feet", "middle"), {}, "feet.middle", "unknown key"),
    "a foot that is a list": (LEFT, [1], "feet.left", "mapping"),
    "a misspelt list of cells": ((*LEFT, "cell"), [], "feet.left.cell", "unknown key"),
    "no channels at all": ((*LEFT, "cells"), DELETE, "feet.left.cells", "0 channels"),
    "an empty list of cells": ((*LEFT, "cells"), [], "feet.left.cells", "at least three"),
    "cells that are a mapping": ((*LEFT, "cells"), {"a": 1}, "feet.left.cells", "list"),
    "two cells": (
        (*LEFT, "cells"), lambda cells: cells[:2], "feet.left.cells", "2 channels"
    ),
    "a cell twice": (
        (*LEFT, "cells"), lambda cells: [*cells, cells[0]], "feet.left.cells", "twice"
    ),
    "cells on one line": (
        (*LEFT, "cells"),
        [{"name": str(k), "position_m": [0.02 * k, 0.01 + 0.01 * k]} for k in range(5)],
        "feet.left.cells",
        "on one line",
    ),
    "cells almost on one line": (
        (*LEFT, "cells"),
        [{"name": str(k), "position_m": [0.03 * k, 0.001 * (k % 2)]} for k in range(4)],
        "feet.left.cells",
        "on one line",
    ),
    "cells on one spot": (
        (*LEFT, "cells"),
        [{"name": str(k), "position_m": [0.02, 0.01]} for k in range(4)],
        "feet.left.cells",
        "on one line",
    ),
    "axes that leave a moment open": (
        LEFT,
        lambda foot: {
            "plates": foot["plates"],
            "six_axis": {"origin_m": [0, 0, 0], "axes": [{"axis": a} for a in ("fx", "fz", "mx")]},
        },
        "feet.left.cells",
        "do not fix",
    ),
    "an axis that does not exist": (
        (*LEFT, "six_axis"),
        {"origin_m": [0, 0, 0], "axes": [{"axis": "mz"}]},
        "feet.left.six_axis.axes[0].axis",
        "one of: fx, fy, fz, mx, my",
    ),
    "an axis twice": (
        (*LEFT, "six_axis"),
        {"origin_m": [0, 0, 0], "axes": [{"axis": "fz"}, {"axis": "fz"}]},
        "feet.left.cells",
        "'left/fz' appears twice",
    ),
    "a sensor without a place": (
        (*LEFT, "six_axis"), {"axes": []}, "feet.left.six_axis.origin_m", "is missing"
    ),
    "a cell without a name": ((*CELL, "name"), DELETE, "feet.left.cells[1].name", "is missing"),
    "a cell without a place": (
        (*CELL, "position_m"), DELETE, "feet.left.cells[1].position_m", "is missing"
    ),
    "a cell with a height": (
        (*CELL, "position_m"), [0, 0, 0], "feet.left.cells[1].position_m", "2 numbers"
    ),
    "a cell nowhere": (
        (*CELL, "position_m"), [0, math.nan], "feet.left.cells[1].position_m", "finite"
    ),
    "a cell in millimetres": (
        (*CELL, "position_m"), [86, 41], "feet.left.cells[1].position_m", "lengths are in m"
    ),
    "a plate in millimetres": (
        (*PLATES, "com_above_m"), [24, 5, 17], "feet.left.plates.com_above_m", "lengths are in m"
    ),
    "a cell with a typing error": (
        (*CELL, "positon_m"), [0, 0], "feet.left.cells[1].positon_m", "unknown key"
    ),
    "a polarity of two": ((*CELL, "polarity"), 2, "feet.left.cells[1].polarity", "1, -1, or 0"),
    "a polarity of one half": (
        (*CELL, "polarity"), 0.5, "feet.left.cells[1].polarity", "whole number"
    ),
    "a nominal gain of zero": (
        (*CELL, "nominal_gain"), 0, "feet.left.cells[1].nominal_gain", "must not be zero"
    ),
    "a nominal gain without bounds": (
        (*CELL, "nominal_gain"), math.inf, "feet.left.cells[1].nominal_gain", "finite"
    ),
    "no plates": (PLATES, DELETE, "feet.left.plates", "is missing"),
    "a plate of negative mass": (
        (*PLATES, "mass_above_kg"), -0.1, "feet.left.plates.mass_above_kg", "at least 0"
    ),
    "a plate without a mass": (
        (*PLATES, "mass_below_kg"), DELETE, "feet.left.plates.mass_below_kg", "is missing"
    ),
    "a plate in a plane": (
        (*PLATES, "com_below_m"), [0, 0], "feet.left.plates.com_below_m", "3 numbers"
    ),
    "a plate with a typing error": (
        (*PLATES, "mass_abov_kg"), 1, "feet.left.plates.mass_abov_kg", "unknown key"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_each_fault_is_one_error_that_names_its_field(name: str, tmp_path: Path) -> None:
    place, value, field, problem = BAD[name]
    path = tmp_path / "shoe.yaml"
    mutations.write_edited(path, shoes.FILES["odd_shoe"], (place, value))
    error = mutations.refused(path, lambda: load_shoe(path))
    assert error.field == field
    assert problem in error.problem


def test_a_newer_format_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "shoe.yaml"
    mutations.write_edited(path, shoes.FILES["odd_shoe"], (("format",), 2))
    with pytest.raises(VersionError, match="update shoecal"):
        load_shoe(path)


def test_no_file(tmp_path: Path) -> None:
    path = tmp_path / "none.yaml"
    assert "No such file" in mutations.refused(path, lambda: load_shoe(path)).problem


@given(st.data())
@settings(max_examples=150)
def test_whatever_happens_to_the_text_there_is_a_shoe_or_one_error(data: st.DataObject) -> None:
    text = data.draw(mutations.mutated(shoes.FILES["odd_shoe"].read_text()))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shoe.yaml"
        path.write_text(text, encoding="utf-8")
        try:
            shoe = load_shoe(path)
        except ShoecalError:
            return
    assert np.isfinite(shoe.columns).all()
    assert np.isfinite(shoe.mass)
    assert all(len(shoe.of_foot(foot)) >= 3 for foot in (0, 1))
    assert len(set(shoe.names)) == len(shoe.names)
