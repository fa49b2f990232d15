"""Markers lie where the model has what they show; what is not measured is not shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from visualization_msgs.msg import Marker, MarkerArray

from core.shoe import shoes
from ros.bodies import nao
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.model.body_shapes import CELL
from shoecal_ros.model.scene_markers import (
    BAD,
    FORCE_HEIGHT,
    FootSeen,
    MeasuredInstant,
    SceneMarkers,
)

ROBOT, SHOE = nao(), shoes.shoe("nao_shoe")


@pytest.fixture(scope="module")
def scene() -> SceneMarkers:
    return SceneMarkers(ROBOT, SHOE, ("l_sole", "r_sole"))


def of(found: MarkerArray, space: str) -> list[Any]:
    return [marker for marker in found.markers if marker.ns == space]


def places(marker: Any) -> np.ndarray:
    return np.array([(point.x, point.y, point.z) for point in marker.points])


def test_without_measurements_only_the_model_is_shown(scene: SceneMarkers) -> None:
    found = scene.at(5_000_000_007, ROBOT.posture, MeasuredInstant())
    assert {marker.ns for marker in found.markers} == {
        "body", "sole", "sensing_polygon", "cells", "com", "cop_modelled",
    }  # fmt: skip
    keys = [(marker.ns, marker.id) for marker in found.markers]
    assert len(set(keys)) == len(keys)
    for marker in found.markers:
        assert marker.action == Marker.ADD
        assert (marker.header.stamp.sec, marker.header.stamp.nanosec) == (5, 7)
        assert marker.header.frame_id in {"l_sole", "r_sole"}
        assert marker.lifetime.sec > 0
        assert marker.color.a > 0.0


def test_centre_of_mass_and_its_projection(scene: SceneMarkers) -> None:
    state = Kinematics(ROBOT).states(ROBOT.posture[None])
    found = scene.at(0, ROBOT.posture, MeasuredInstant())
    (modelled,) = of(found, "cop_modelled")
    where = modelled.pose.position
    assert (where.x, where.y, where.z) == pytest.approx((*state.cop[0, 0], 0.0), abs=1e-9)
    ball, line = of(found, "com")
    assert np.allclose(places(line)[:, 0], ball.pose.position.x)
    assert places(line)[:, 2].tolist() == [ball.pose.position.z, 0.0]


def test_forces_stand_at_the_measured_cop_and_are_as_long_as_strong(scene: SceneMarkers) -> None:
    left = FootSeen(True, 0.25 * ROBOT.weight, np.array([0.03, 0.01]))
    right = FootSeen(True, 0.75 * ROBOT.weight, np.array([-0.02, 0.0]))
    found = scene.at(0, ROBOT.posture, MeasuredInstant((left, right), 1, np.array([0.01, 0.05])))
    weak, strong = of(found, "force")
    assert (weak.header.frame_id, strong.header.frame_id) == ("l_sole", "r_sole")
    assert places(weak)[0] == pytest.approx([0.03, 0.01, 0.0])
    assert np.ptp(places(strong), axis=0)[2] == pytest.approx(3.0 * np.ptp(places(weak), axis=0)[2])
    (ball, *_) = of(found, "com")
    both = np.ptp(places(weak), axis=0)[2] + np.ptp(places(strong), axis=0)[2]
    assert both == pytest.approx(FORCE_HEIGHT * ball.pose.position.z, rel=1e-6)
    (measured,) = of(found, "cop_measured")
    assert measured.header.frame_id == "r_sole"
    (hull,) = of(found, "support_polygon")
    assert places(hull)[0].tolist() == places(hull)[-1].tolist()


def test_a_foot_that_carries_nothing_has_no_force_and_no_hull(scene: SceneMarkers) -> None:
    seen = (FootSeen(True, ROBOT.weight, np.zeros(2)), FootSeen(False, 0.1, None))
    found = scene.at(0, ROBOT.posture, MeasuredInstant(seen, 0, np.zeros(2)))
    assert len(of(found, "force")) == 1
    assert not of(found, "support_polygon")


def test_cells_that_are_not_well_are_marked(scene: SceneMarkers) -> None:
    seen = (FootSeen(bad=frozenset({SHOE.names[0]})), FootSeen())
    cells = of(scene.at(0, ROBOT.posture, MeasuredInstant(seen)), "cells")
    assert len(cells) == len(SHOE.names)
    colours = [(cell.color.r, cell.color.g, cell.color.b) for cell in cells]
    assert colours[0] == pytest.approx(BAD[:3], abs=1e-6)
    assert all(colour == pytest.approx(CELL[:3], abs=1e-6) for colour in colours[1:])


def test_triangles_look_outwards(scene: SceneMarkers) -> None:
    for marker in of(scene.at(0, ROBOT.posture, MeasuredInstant()), "body"):
        if marker.type == Marker.TRIANGLE_LIST:
            corners = places(marker).reshape(-1, 3, 3)
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            middle = corners.reshape(-1, 3).mean(axis=0)
            away = np.einsum("ij,ij->i", normal, corners.mean(axis=1) - middle)
            assert (away > -1e-12).all()
