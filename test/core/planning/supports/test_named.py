from __future__ import annotations

import numpy as np
import pytest

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS, planner_of
from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import NAMED, named_support, named_supports


@pytest.mark.parametrize("name", NAMES)
def test_each_goes_as_far_as_can_be(name: str) -> None:
    feasible = Feasible(load_body(name).robot, SETTINGS)
    neutral = load_body(name).robot.support_range.neutral
    found = {each: named_support(each, feasible) for each in NAMED}
    assert [found["neutral"].dx, found["neutral"].dy, found["neutral"].dtheta] == list(neutral)
    for each, support in found.items():
        assert each == "neutral" or feasible.can_stand(support)
        most = NAMED[each].most
        if most is not None:
            assert most(support) == max(map(most, found.values()))
    assert found["toes_out"].dtheta < -0.2 < 0.2 < found["toes_in"].dtheta
    assert found["left_ahead"].dx < 0.0 < found["right_ahead"].dx


def test_the_paper_s_supports_are_planned_with_their_landmarks_reached() -> None:
    planner = planner_of("nao")
    supports = named_supports("paper", Feasible(load_body("nao").robot, SETTINGS))
    assert len(set(supports)) == 9
    for support in supports:
        motion = planner.plan(support)
        assert np.sum(motion.path.nearest < SETTINGS.landmark_radius) >= 4, support
        assert np.all(motion.path.nearest < 2.0 * SETTINGS.landmark_radius), support


def test_a_stance_that_nobody_knows() -> None:
    with pytest.raises(NameNotFoundError, match=r"stance named 'split' .*toes_in"):
        named_support("split", Feasible(load_body("nao").robot, SETTINGS))
