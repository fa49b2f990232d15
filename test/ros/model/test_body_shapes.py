"""The robot's body as shapes: where kinematics has it, on the floor, cells within the shoes."""

from __future__ import annotations

import numpy as np
import pytest

from core.robot import robots
from core.shoe import shoes
from shoecal_core.errors import ShapeError
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.model.body_shapes import (
    BODY,
    CELL,
    LEFT,
    RIGHT,
    LinkShape,
    body_shapes,
    joints_at,
)


def test_the_body_stands_where_kinematics_says() -> None:
    robot = robots.load("nao")
    at = joints_at(robot, robot.posture)
    state = Kinematics(robot).states(robot.posture[None])
    assert np.allclose(at.soles[0].homogeneous, np.eye(4), atol=1e-12)
    assert np.allclose(at.soles[1].translation, state.translation[0], atol=1e-9)
    assert np.allclose(at.com[:2], state.cop[0, 0], atol=1e-9)
    with pytest.raises(ShapeError):
        joints_at(robot, robot.posture[:-1])


def test_feet_stand_on_the_floor_and_cells_lie_in_the_shoes() -> None:
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    shapes = body_shapes(robot, shoe, joints_at(robot, robot.posture))
    lowest = min(float((shape.points[:, 2] - shape.radius).min()) for shape in shapes)
    assert lowest == pytest.approx(0.0, abs=1e-9)
    cells = [shape for shape in shapes if shape.rgba == CELL]
    assert len(cells) == len(shoe.names)
    bare = body_shapes(robot, shoe, joints_at(robot, robot.posture), cells=False)
    assert len(bare) == len(shapes) - len(cells)
    for cell in cells:
        assert 0.0 < cell.points[:, 2].min() < cell.points[:, 2].max() < shoe.height
    assert {LEFT, RIGHT, BODY} <= {shape.rgba for shape in shapes}


@pytest.mark.parametrize("name", ["nao", "wren"])
def test_a_lifted_foot_leaves_the_stance_foot_where_it_is(name: str) -> None:
    robot = robots.load(name)
    for stance in (0, 1):
        at = joints_at(robot, robot.posture, stance)
        assert np.allclose(at.soles[stance].translation, 0.0, atol=1e-12)


def test_a_shape_needs_points() -> None:
    with pytest.raises(ShapeError):
        LinkShape(np.zeros(3), 0.1, CELL)
