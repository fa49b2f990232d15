from __future__ import annotations

import numpy as np
import pytest

from core.simulation.test_disturbances import standing_still
from core.simulation.worlds import PERFECT, World
from shoecal_core.simulation.samples import run
from shoecal_core.workflows.replayed import place_showing


def test_it_stands_as_the_recorded_one_did(world: World) -> None:
    recorded = world.standing(PERFECT)
    shown = recorded.joints().angles
    plain, sim = world.simulate(PERFECT), world.simulate(PERFECT)
    plain.place(shown)
    place_showing(sim, shown)
    missed = [np.abs(one.joints().angles - shown).max() for one in (plain, sim)]
    assert missed[1] < 0.3 * missed[0]


def test_a_run_repeated_from_there_is_the_same(nao: World) -> None:
    recorded = nao.standing(PERFECT)
    shown = recorded.joints().angles
    motion = standing_still(recorded, 2.0)
    first = run(recorded, motion, 50.0)
    again = nao.simulate(PERFECT)
    place_showing(again, shown)
    second = run(again, motion, 50.0)
    still = first.time - first.time[0] > 1.0
    assert second.truth.foot_cop[still] == pytest.approx(first.truth.foot_cop[still], abs=2e-4)
