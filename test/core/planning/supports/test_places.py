from __future__ import annotations

import shapely

from core.planning.bodies import Body
from shoecal_core.planning.supports.places import places_over


def test_places_cover_the_polygon(body: Body) -> None:
    polygon = body.robot.feet[0].sensing_polygon
    places = places_over(polygon)
    area = shapely.Polygon(polygon)
    assert all(area.distance(shapely.Point(place)) < 1e-9 for place in places)
    assert area.difference(shapely.MultiPoint(places).buffer(0.012)).area < 0.02 * area.area
