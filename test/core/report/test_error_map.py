"""Maps of expected errors: their colours, their borders, and what has no place on them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.report.pages import read_svg
from core.robot import robots
from core.shoe import shoes
from shoecal_core.errors import ShapeError
from shoecal_core.planning.supports.places import places_over
from shoecal_core.report.figures.error_map import ErrorMap, common_levels, error_map
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.palette import SIZES


def map_of(low: float, high: float) -> ErrorMap:
    """Errors of the left foot that grow from rear to front [m]."""
    shape = foot_shape(robots.load("nao"), shoes.shoe("nao_shoe"), 0)
    places = places_over(shape.sensing_polygon)
    share = (places[:, 0] - places[:, 0].min()) / np.ptp(places[:, 0])
    return ErrorMap("left foot", (shape,), places, low + (high - low) * share)


@given(low=st.floats(0.0, 0.1), more=st.floats(0.0, 0.3))
def test_every_error_has_a_colour(low: float, more: float) -> None:
    levels = common_levels([map_of(low, low + more)])
    assert 2 <= len(levels) <= len(SIZES) + 1
    assert levels[0] <= 1e3 * low + 1e-6
    assert levels[-1] >= 1e3 * (low + more) - 1e-6
    assert (np.diff(levels) > 0.0).all()


def test_larger_errors_have_the_stronger_colour() -> None:
    one = map_of(1e-3, 6e-3)
    root = read_svg(error_map([one], common_levels([one])))
    styles = [path.get("style", "") for path in root.iter("path")]
    used = [name for name in (f"size{n}" for n in range(1, 7)) if any(name in s for s in styles)]
    assert len(used) >= 4
    assert "left foot: 1.0 to 6.0 mm" in root.attrib["aria-label"]
    assert {"CoP error (mm)", "sensing polygon", "x, forward (mm)"} <= set(root.itertext())


def test_two_maps_share_their_colours() -> None:
    small, large = map_of(1e-3, 1.2e-3), map_of(7e-3, 9e-3)
    levels = common_levels([small, large])
    assert levels[0] <= 1.0
    assert levels[-1] >= 9.0
    root = read_svg(error_map([small, large], levels))
    assert "left foot: 7.0 to 9.0 mm" in root.attrib["aria-label"]


def test_places_without_a_cop_are_left_out() -> None:
    one = map_of(1e-3, 2e-3)
    one.length[::2] = np.nan
    read_svg(error_map([one], common_levels([one])))
    nothing = ErrorMap("none", one.feet, one.places, np.full(len(one.length), np.nan))
    root = read_svg(error_map([nothing], common_levels([nothing])))
    assert "none: none known" in root.attrib["aria-label"]


def test_one_error_everywhere() -> None:
    flat = map_of(3e-3, 3e-3)
    read_svg(error_map([flat], common_levels([flat])))


def test_a_length_for_every_place() -> None:
    with pytest.raises(ShapeError, match=r"map\.places"):
        ErrorMap("x", (), np.zeros((3, 2)), np.zeros(2))
