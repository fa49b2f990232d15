from __future__ import annotations

import numpy as np
import pytest

from core.simulation.effects.chains import NAO, SIX_AXIS, item, shoes_with, through
from core.simulation.worlds import PERFECT, World, changed
from shoecal_core.shoe import wrench

SIDEWAYS = np.array([[1.0, -2.0], [3.0, 0.5]])
"""N; on left, right along x, y."""


def test_a_foots_cells_share_what_sideways_forces_add() -> None:
    shoes = shoes_with(item("off_axis_load", "left", x=0.1, y=-0.2))
    reached = through(shoes, np.full((1, 8), 5.0), sideways=SIDEWAYS)[0]
    assert reached == pytest.approx([5.125] * 4 + [5.0] * 4)


def test_of_a_six_axis_sensor_the_vertical_force_shows_them() -> None:
    shoes = shoes_with(item("off_axis_load", "all", x=0.1, y=-0.2), shoe=SIX_AXIS)
    reached = through(shoes, np.zeros((1, 10)), sideways=SIDEWAYS)[0]
    expected = dict.fromkeys(SIX_AXIS.names, 0.0) | {"left/fz": 0.5, "right/fz": 0.2}
    assert reached == pytest.approx(list(expected.values()))


def test_the_sideways_forces_are_those_of_the_contact(nao: World) -> None:
    rules = changed(PERFECT, joints__encoder_error_rad={"LHipRoll": 0.004})
    plain = nao.standing(rules)
    sim = nao.standing(changed(rules, item("off_axis_load", "right", x=0.3, y=-0.4)))
    sideways = sim.truth().foot_force[1, :2]
    assert np.abs(sideways).max() > 0.5
    added = (sim.snapshot().felt - plain.snapshot().felt)[4:]
    assert added == pytest.approx(np.full(4, sideways @ [0.3, -0.4] / 4.0))


def test_a_plate_rests_where_its_cells_truly_are(nao: World) -> None:
    moved = item("cell_position", "left/front_left", x_m=0.006, y_m=-0.004)
    sim = nao.standing(changed(PERFECT, moved))
    left, felt = NAO.of_foot(0), sim.snapshot().felt
    places = NAO.positions[left].copy()
    weighed = felt[left] @ places / felt[left].sum()
    places[0] += 0.006, -0.004
    true = felt[left] @ places / felt[left].sum()
    cop = wrench.cop(wrench.foot_wrenches(NAO, felt), 1.0)[0]
    # Up to the weight of the plate below the cells.
    assert sim.truth().foot_cop[0] - cop == pytest.approx(true - weighed, abs=2e-4)
    assert np.linalg.norm(true - weighed) > 1e-3
