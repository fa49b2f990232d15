from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import nao
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.planner.foot_load import UNEVEN, LoadWatch, least_shares, needed_shares

LEFT, RIGHT = (foot.outline for foot in nao().feet)
SUPPORT = DoubleSupport(0.02, -0.11, 0.1)
AT_RIGHT = SUPPORT.right_to_left(RIGHT)
weights = st.lists(st.floats(0.01, 1.0), min_size=len(LEFT), max_size=len(LEFT))
TIME = np.linspace(0.0, 10.0, 501)


@given(weights, weights, st.floats(0.0, 1.0))
def test_no_foot_needs_more_than_what_it_may_carry(
    left: list[float], right: list[float], share: float
) -> None:
    under_left = np.average(LEFT, axis=0, weights=left[: len(LEFT)])
    under_right = np.average(AT_RIGHT, axis=0, weights=right[: len(AT_RIGHT)])
    cop = ((1.0 - share) * under_left + share * under_right)[None]
    assert least_shares(cop, AT_RIGHT, LEFT)[0] <= share + 1e-9
    assert least_shares(cop, LEFT, AT_RIGHT)[0] <= 1.0 - share + 1e-9


def test_a_foot_that_need_not_carry() -> None:
    inside = LEFT.mean(axis=0)[None]
    assert least_shares(inside, AT_RIGHT, LEFT) == pytest.approx([0.0])
    assert least_shares(inside, LEFT, AT_RIGHT)[0] > 0.3


def test_the_least_share_is_found() -> None:
    """Two feet that are squares: between them the share grows from one edge to the other."""
    square = np.array([[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]])
    other = square - [0.0, 0.2]
    cop = np.array([[0.0, -0.05], [0.0, -0.1], [0.0, -0.15]])
    assert least_shares(cop, other, square) == pytest.approx([0.0, 0.25, 0.5])
    assert least_shares(cop, square, other) == pytest.approx([0.5, 0.25, 0.0])


def test_between_the_feet_both_should_carry() -> None:
    middle = ((LEFT.mean(axis=0) + AT_RIGHT.mean(axis=0)) / 2.0)[None]
    for own, other in ((LEFT, AT_RIGHT), (AT_RIGHT, LEFT)):
        assert needed_shares(middle, own, other) == pytest.approx([0.5 - UNEVEN])
        assert needed_shares(other.mean(axis=0)[None], own, other) == pytest.approx([0.0])
        assert needed_shares(own.mean(axis=0)[None], own, other)[0] >= 1.0 - UNEVEN


def watch(needed_left: float = 20.0, needed_right: float = 20.0) -> LoadWatch:
    needed = np.tile([needed_left, needed_right], (len(TIME), 1))
    return LoadWatch(TIME, needed, least=12.0, late_s=1.0, patience_s=0.3)


def test_a_foot_that_loses_its_load_is_named_after_a_while() -> None:
    one = watch()
    assert one.look(2.0, (True, True)) == ""
    assert one.look(3.0, (True, False)) == ""
    assert one.look(3.2, (True, False)) == ""
    assert one.look(3.31, (True, False)) == (
        "the right foot carries nothing, where the planned CoP puts at least 20 N on it"
    )


def test_a_load_that_comes_back_is_not_lost() -> None:
    one = watch()
    assert not one.look(3.0, (False, True))
    assert not one.look(3.2, (True, True))
    assert not one.look(3.4, (False, True))
    assert not one.look(3.6, (False, True))
    assert "left" in one.look(3.8, (False, True))


@pytest.mark.parametrize("loaded", [(True, None), (None, None), (True, True)])
def test_what_nobody_knows_is_no_concern(loaded: tuple[bool | None, bool | None]) -> None:
    one = watch()
    assert not any(one.look(time, loaded) for time in (1.0, 2.0, 3.0))


def test_a_foot_that_needs_little_may_carry_nothing() -> None:
    one = watch(needed_right=5.0)
    assert not any(one.look(time, (True, False)) for time in (1.0, 2.0, 3.0))


def test_a_late_robot_is_given_its_time() -> None:
    needed = np.zeros((len(TIME), 2))
    needed[TIME > 5.0, 0] = 30.0
    one = LoadWatch(TIME, needed, least=12.0, late_s=1.0, patience_s=0.3)
    assert not any(one.look(time, (False, True)) for time in (5.1, 5.5, 6.0, 6.25))
    assert one.look(7.0, (False, True))
    assert one.look(20.0, (False, True)), "the end of the motion stays"
