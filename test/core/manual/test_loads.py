from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.manual.benches import nao_shoe, odd_shoe
from core.shoe import shoes
from shoecal_core.errors import FileError
from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.shoe.shoe import Shoe

WEIGHTS = (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)


def test_the_papers_loads() -> None:
    shoe = nao_shoe()
    loads = planned_loads(SHOE, shoe, WEIGHTS)
    for foot in (0, 1):
        own = [load for load in loads if load.foot == foot]
        assert own[0] == Load(foot, "", 0.0)
        assert len(own) == 1 + 6 * 3 * 7
        assert len(set(own)) == len(own)
    assert [load.mass for load in planned_loads(SHOE, shoe, (2.0,), (1,))] == [0.0] + [2.0] * 18


def test_little_carrying() -> None:
    shoe = nao_shoe()
    loads = [load for load in planned_loads(SHOE, shoe, WEIGHTS, (0,)) if load.place]
    holes = shoe.holes[0]
    assert holes is not None
    places = np.array([holes.position(load.place) for load in loads])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    masses = np.array([load.mass for load in loads])
    # A weight is taken up once, goes from hole to neighbouring hole, and the next begins there.
    assert np.sum(np.diff(masses) != 0.0) == len(WEIGHTS) - 1
    assert steps[np.diff(masses) != 0.0] == pytest.approx(0.0)
    assert steps.max() < 0.03


def test_every_cell_without_and_with_each_weight(tmp_path: Path) -> None:
    shoe = odd_shoe(tmp_path)
    loads = planned_loads(CELLS, shoe, (1.0, 2.0))
    assert [load.place for load in loads] == [name for name in shoe.names for _ in range(3)]
    assert [load.mass for load in loads] == [0.0, 1.0, 2.0] * len(shoe.names)
    assert [load.foot for load in loads[::3]] == shoe.foot.tolist()


def test_a_shoe_without_holes_says_so() -> None:
    with pytest.raises(FileError, match=r"odd_shoe.yaml: feet.left.holes: .*no places for weights"):
        planned_loads(SHOE, shoes.shoe("odd_shoe"), WEIGHTS)


def test_six_axis_sensors_are_no_cells() -> None:
    ankles: Shoe = shoes.made(
        [*shoes.six_axis(0, (0.0, 0.0, 0.1)), *shoes.six_axis(1, (0.0, 0.0, 0.1))]
    )
    with pytest.raises(FileError, match=r"left/fx.* one-axis cells"):
        planned_loads(CELLS, ankles, (1.0,))
