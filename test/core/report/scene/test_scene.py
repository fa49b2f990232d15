"""The robot in three dimensions: shapes where kinematics has them, pictures of what is there."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from core.robot import robots
from core.shoe import shoes
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.report.page import Still
from shoecal_core.report.scene import offscreen
from shoecal_core.report.scene.body import BODY, CELL, LEFT, RIGHT, body_shapes, joints_at
from shoecal_core.report.scene.offscreen import (
    FOVY,
    SWITCH,
    Camera,
    NoPictureError,
    Viewpoint,
    draw,
    framed,
    tried,
)
from shoecal_core.report.scene.shapes import LinkShape, arrow, dashes, disc, path, prism
from shoecal_core.report.scene.stills import HEIGHT, WIDTH, instant, stills
from shoecal_core.robot.kinematics import Kinematics

RED = (1.0, 0.0, 0.0, 1.0)


def picture(view: Viewpoint) -> np.ndarray:
    try:
        (file,) = draw([view], "png")
    except NoPictureError as error:
        if "OpenGL" not in str(error):
            raise
        pytest.skip(str(error))
    return np.asarray(Image.open(io.BytesIO(file)))


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


def test_a_camera_has_everything_in_view_and_no_more_than_needed() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        shapes = [LinkShape(rng.normal(size=(4, 3)), 0.05, RED) for _ in range(3)]
        azimuth, elevation = rng.uniform(-180.0, 180.0), rng.uniform(-80.0, 20.0)
        camera = framed(shapes, azimuth, elevation, 0.7)
        right, up, sight = offscreen._axes(np.radians(azimuth), np.radians(elevation))
        eye = np.array(camera.target) - camera.distance * sight
        seen = np.vstack([shape.points for shape in shapes]) - eye
        depth, tangent = seen @ sight, np.tan(np.radians(FOVY) / 2.0)
        part = np.maximum(np.abs(seen @ up) / (depth * tangent),
                          np.abs(seen @ right) / (depth * tangent * 0.7))  # fmt: skip
        assert 0.8 < part.max() < 1.0


def test_lines_break_where_nothing_is_known() -> None:
    places = np.array(
        [[0, 0, 0], [1, 0, 0], [np.nan, 0, 0], [2, 0, 0], [3, 0, 0], [3, 0, 0]], float
    )
    assert len(path(places, 0.01, RED)) == 2
    with pytest.raises(ShapeError):
        LinkShape(np.zeros(3), 0.1, RED)


def test_a_picture_shows_what_is_there_on_a_clear_ground() -> None:
    ball = LinkShape(np.zeros((1, 3)), 0.1, RED)
    shown = picture(Viewpoint([ball], Camera((0.0, 0.0, 0.0), 1.0, 180.0, 0.0), 60, 80))
    assert shown.shape == (80, 60, 4)
    assert shown[0, 0, 3] == 0
    red, green, _, clear = shown[40, 30]
    assert clear == 255
    assert red > 2 * green
    # The ball's outline: radius over distance, beside half the angle of view.
    rows = np.flatnonzero(shown[:, 30, 3] > 127)
    wide = np.tan(np.arcsin(0.1)) / np.tan(np.radians(FOVY) / 2.0)
    assert np.ptp(rows) + 1 == pytest.approx(80 * wide, abs=2.0)


def test_what_stands_within_a_leg_is_seen_and_nothing_behind_it_is_black() -> None:
    leg = LinkShape(np.array([[0.0, 0.0, -0.2], [0.0, 0.0, 0.2]]), 0.05, LEFT)
    within = LinkShape(np.array([[0.0, 0.0, -0.05], [0.0, 0.0, 0.05]]), 0.02, RED)
    camera = framed([leg], 155.0, -24.0, 1.0)
    alone, filled = (
        picture(Viewpoint(shapes, camera, 60, 60)) for shapes in ([leg], [leg, within])
    )
    assert alone[30, 30, 2] > 120
    # Blue over light, and blue over red.
    assert alone[30, 30, 0] < alone[30, 30, 1]
    assert filled[30, 30, 0] > filled[30, 30, 1]
    assert alone[30, 30, 3] == filled[30, 30, 3] == 255


def test_every_kind_of_shape_can_be_drawn() -> None:
    low, high = np.zeros(3), np.array([0.0, 0.0, 0.3])
    shapes = [
        *arrow(low, 0.3, 0.01, RED),
        *dashes(low, high, 0.004, RED),
        LinkShape(prism(disc(np.zeros(2), 0.1), -0.01, 0.0), 0.0, RED),
        LinkShape(np.array([low, high, (0.1, 0.0, 0.1)]), 0.02, RED),
        LinkShape(np.array([low, low]), 0.02, RED),
    ]
    shown = picture(Viewpoint(shapes, framed(shapes, 150.0, -15.0, 1.0), 40, 40))
    assert shown[..., 3].any()


def test_stills_are_the_same_every_time() -> None:
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    seen = instant(robot, "1.0 s", robot.posture, np.array([0.02, -0.05]), 1.0, np.zeros((1, 2)))
    unknown = instant(robot, "2.0 s", robot.posture, np.full(2, np.nan), 0.0, np.zeros((0, 2)))
    made = [tried(lambda: stills(robot, shoe, [[seen, unknown]])) for _ in range(2)]
    if isinstance(made[0], str):
        pytest.skip(made[0])
    assert made[0] == made[1]
    assert [(one.width, one.height) for one in made[0][0]] == [(WIDTH, HEIGHT)] * 2
    assert made[0][0][0].label == "1.0 s"


def test_where_nothing_can_draw_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def never() -> str:
        raise NoPictureError("no picture of the robot: no driver")

    assert tried(never) == "No picture of the robot: no driver."
    monkeypatch.setenv(SWITCH, "0")
    with pytest.raises(NoPictureError, match=SWITCH):
        draw([])


def test_a_missing_driver_names_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(offscreen, "BACKENDS", ("none",))
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(NoPictureError, match="apt install"):
        draw([])


def test_what_cannot_be_drawn_is_told_with_its_reason() -> None:
    flat = LinkShape(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), 0.0, RED)
    with pytest.raises(NoPictureError, match="no picture of the robot"):
        draw([Viewpoint([flat], Camera((0.0, 0.0, 0.0), 1.0, 180.0, 0.0), 20, 20)])


def test_a_page_holds_its_pictures_itself() -> None:
    with pytest.raises(ShoecalError, match="by itself"):
        Still("https://example.org/robot.png", "1.0 s", "", 10, 10)
