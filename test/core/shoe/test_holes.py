from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from core.shoe import mutations, shoes
from core.shoe.mutations import Key
from shoecal_core.errors import NameNotFoundError
from shoecal_core.shoe.holes import Holes
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.shoe_file import load_shoe

ROBOT = shoes.ROOT / "config" / "robots" / "nao.yaml"


def nao_holes(foot: int) -> Holes:
    holes = shoes.shoe("nao_shoe").holes[foot]
    assert holes is not None
    return holes


@pytest.mark.parametrize("foot", [0, 1])
def test_the_naos_holes_cover_its_sensing_polygon(foot: int) -> None:
    holes = nao_holes(foot)
    robot = yaml.safe_load(ROBOT.read_text())
    polygon = np.array(robot["feet"][FEET[foot]]["sensing_polygon_m"])
    np.testing.assert_allclose(holes.positions.min(axis=0), polygon.min(axis=0))
    np.testing.assert_allclose(holes.positions.max(axis=0), polygon.max(axis=0))
    assert len(holes.names) == 18
    assert len(np.unique(holes.positions[:, 0])) == 6
    assert len(np.unique(holes.positions[:, 1])) == 3


def test_names_begin_at_the_left_toe() -> None:
    holes = nao_holes(0)
    assert (holes.names[0], holes.names[-1]) == ("a1", "f3")
    np.testing.assert_array_equal(holes.position("a1"), holes.positions.max(axis=0))
    np.testing.assert_array_equal(holes.position("f3"), holes.positions.min(axis=0))
    with pytest.raises(NameNotFoundError, match="no hole named 'g1'"):
        holes.position("g1")


@pytest.mark.parametrize("foot", [0, 1])
def test_a_walk_visits_every_hole_once_and_never_far(foot: int) -> None:
    holes = nao_holes(foot)
    walk = holes.walk()
    assert sorted(walk) == sorted(holes.names)
    places = np.array([holes.position(name) for name in walk])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.03


def test_shoes_need_no_holes() -> None:
    assert shoes.shoe("odd_shoe").holes == (None, None)


LEFT: tuple[Key, ...] = ("feet", "left", "holes")
BAD: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "a hole outside the cells": (
        (*LEFT, "x_m"), [0.09, 0.0, -0.03], "feet.left.holes", "a1 at (0.09, 0.0299) m is not"
    ),
    "holes in millimetres": (
        (*LEFT, "y_m"), [29.9, 3.4, -23.1], "feet.left.holes", "lengths are in m"
    ),
    "a row twice": ((*LEFT, "x_m"), [0.01, 0.01], "feet.left.holes.x_m", "apart"),
    "no columns": ((*LEFT, "y_m"), [], "feet.left.holes.y_m", "is empty"),
    "one number": ((*LEFT, "y_m"), 0.0, "feet.left.holes.y_m", "expected n numbers"),
    "no rows": ((*LEFT, "x_m"), mutations.DELETE, "feet.left.holes.x_m", "is missing"),
    "an unknown key": ((*LEFT, "z_m"), [0.0], "feet.left.holes.z_m", "unknown key"),
    "more rows than letters": (
        (*LEFT, "x_m"), [0.0021 * k - 0.03 for k in range(27)], "feet.left.holes.x_m", "27 rows"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_each_fault_is_one_error_that_names_its_field(name: str, tmp_path: Path) -> None:
    place, value, field, problem = BAD[name]
    path = tmp_path / "shoe.yaml"
    mutations.write_edited(path, shoes.FILES["nao_shoe"], (place, value))
    error = mutations.refused(path, lambda: load_shoe(path))
    assert error.field == field
    assert problem in error.problem


def test_a_six_axis_foot_bears_a_weight_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "shoe.yaml"
    axes = {"origin_m": [0, 0, 0.05], "axes": [{"axis": a} for a in ("fz", "mx", "my")]}
    foot: tuple[Key, ...] = ("feet", "left")
    mutations.write_edited(
        path,
        shoes.FILES["nao_shoe"],
        ((*foot, "six_axis"), axes),
        ((*foot, "cells"), mutations.DELETE),
    )
    assert load_shoe(path).holes[0] is not None
