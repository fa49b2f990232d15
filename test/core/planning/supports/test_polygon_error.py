from __future__ import annotations

import numpy as np
import pytest
import shapely

from core.planning.bodies import Body
from shoecal_core.planning.supports.polygon_error import places_over, polygon_error
from shoecal_core.shoe.wrench import ChannelParameters


def test_an_offset_in_every_cell_shifts_the_force_by_their_number(nao: Body) -> None:
    """All offsets off together by 0.1 N: 0.8 N in both feet, 0.4 N in each."""
    together = np.concatenate((np.zeros(8), np.full(8, 0.1)))
    got = polygon_error(nao.robot, nao.shoe, np.outer(together, together))
    assert got.grf.rms == pytest.approx(0.8)
    assert [foot.worst for foot in got.foot_grf] == pytest.approx([0.4, 0.4])


def test_one_common_relative_gain_shifts_no_cop(body: Body) -> None:
    """Only the parts below the cells, which no gain scales, keep it from being exact."""
    count = len(body.shoe.channels)
    together = np.concatenate((np.full(count, 0.05), np.zeros(count)))
    got = polygon_error(body.robot, body.shoe, np.outer(together, together))
    assert got.grf.rms == pytest.approx(0.05 * body.robot.weight, rel=0.05)
    assert got.cop.worst < 2e-4
    assert got.worst_foot_cop < 2e-4


def test_parameters_tell_what_a_gain_does(body: Body) -> None:
    """An absolute gain acts on readings, a relative one on newtons."""
    count = len(body.shoe.channels)
    generator = np.random.default_rng(0)
    parameters = ChannelParameters(generator.uniform(-15.0, -5.0, count), np.zeros(count))
    root = 0.01 * generator.normal(size=(2 * count, 2 * count))
    scale = np.concatenate((parameters.gain, np.ones(count)))
    relative = polygon_error(body.robot, body.shoe, root @ root.T)
    absolute = polygon_error(
        body.robot, body.shoe, root @ root.T * np.outer(scale, scale), parameters
    )
    assert relative.to_json() == pytest.approx(absolute.to_json())
    assert relative.cop.rms < relative.cop.worst


def test_places_cover_the_polygon(body: Body) -> None:
    polygon = body.robot.feet[0].sensing_polygon
    places = places_over(polygon)
    area = shapely.Polygon(polygon)
    assert all(area.distance(shapely.Point(place)) < 1e-9 for place in places)
    assert area.difference(shapely.MultiPoint(places).buffer(0.012)).area < 0.02 * area.area
