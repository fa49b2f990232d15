from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, PERIOD, item, on_first, shoes_with, through
from core.simulation.worlds import DEFAULT
from shoecal_core.simulation.sampled_robot import draw_shoes

CELL = "left/front_left"
RISE = on_first(NAO, np.linspace(0.0, 10.0, 101))


@settings(max_examples=25)
@given(st.floats(0.05, 1.0), st.integers(0, 100))
def test_a_stuck_cell_stays_where_it_was(share: float, since: int) -> None:
    shoes = shoes_with(item("stuck_cell", CELL, share=share, time_s=since * PERIOD))
    reached, force = through(shoes, RISE)[:, 0], RISE[:, 0]
    stuck = np.arange(101) * PERIOD >= since * PERIOD
    assert reached[~stuck] == pytest.approx(force[~stuck])
    held = force[max(0, since - 1)]
    assert reached[stuck] == pytest.approx((1.0 - share) * force[stuck] + share * held)


def test_swapped_cells_show_each_other_by_their_own_laws() -> None:
    swapped = item("swapped_cells", CELL, "left/rear_left")
    shoes, plain = shoes_with(swapped, rules=DEFAULT), draw_shoes(DEFAULT, NAO, 1)
    forces = np.arange(1.0, 9.0)[None]
    before, after = (
        (through(one, forces)[0] - one.parameters.offset) / one.parameters.gain
        for one in (plain, shoes)
    )
    order = [2, 1, 0, 3, 4, 5, 6, 7]
    assert after == pytest.approx(before[order])


def test_a_receiver_shows_what_the_donor_shows() -> None:
    shoes = shoes_with(
        item("crosstalk", CELL, "right/rear_left", fraction=0.1),
        item("saturation", "right/rear_left", level_n=2.0),
    )
    forces = np.full((1, 8), 20.0)
    assert through(shoes, forces)[0, 0] == pytest.approx(20.2)
    assert through(shoes, forces)[0, 6] == pytest.approx(2.0)


def test_a_stuck_cell_sticks_behind_the_wrong_socket_too() -> None:
    effects = (
        item("swapped_cells", CELL, "left/rear_left"),
        item("stuck_cell", CELL, share=1.0, time_s=0.0),
    )
    assert through(shoes_with(*effects), RISE) == pytest.approx(0.0 * RISE)
    assert through(shoes_with(*effects[::-1]), RISE) == pytest.approx(0.0 * RISE)
