"""The page of a plan: whole, alone, safe, and its animation shows the motion."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from core.report import plans
from core.report.pages import Document, read
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.planning.checking.findings import Report
from shoecal_core.report.html import render
from shoecal_core.report.plan.animation import animation, lifted
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.plan.figures import motion_pictures, moved
from shoecal_core.report.plan.report import Unplanned, plan_page, verdict, write_plan
from shoecal_core.report.player import Player, PlayerPoints
from shoecal_core.robot.double_support import DoubleSupport

HOSTILE = "<script>alert(1)</script>\"'&amp;"
SVG = "{http://www.w3.org/2000/svg}"


def page(*motions: PlannedMotion) -> str:
    return render(plan_page(motions, [motion_pictures(motion) for motion in motions]))


@pytest.fixture(scope="module")
def html() -> str:
    return page(plans.missing(), plans.stepping())


@pytest.fixture(scope="module")
def document(html: str) -> Document:
    return read(html)


@pytest.fixture(scope="module")
def player() -> Player:
    return animation(plans.stepping())


def test_nothing_comes_from_elsewhere(html: str, document: Document) -> None:
    assert all(link.startswith("#") for link in document.links)
    assert {link.removeprefix("#") for link in document.links} <= set(document.ids)
    assert not re.search(r"@import|url\(\s*['\"]?(?!#)|https?:", html)
    assert not {"link", "iframe", "object", "embed", "img"} & set(document.tags)
    assert not {name for name in document.attributes if name.startswith("on")}


def test_motions_after_the_first_are_folded(document: Document) -> None:
    assert document.tags["details"] == 1
    assert "/shoe/self_calibrate plans and moves" in document.text


def test_only_the_pages_own_script_may_run(html: str) -> None:
    scripts = re.findall(r"<script([^>]*)>(.*?)</script>", html, flags=re.DOTALL)
    running = [text for kind, text in scripts if "application/json" not in kind]
    assert len(scripts) == 3
    assert len(running) == 1
    digest = base64.b64encode(hashlib.sha256(running[0].encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in html
    assert "default-src 'none'" in html
    assert not re.search(r"fetch|XMLHttp|import\(|eval|innerHTML", running[0])


def test_it_says_that_it_is_a_plan(document: Document) -> None:
    assert "A plan, computed from the robot’s model; nothing was measured." in document.text
    assert "Computed from the model: nothing was measured." in document.text


def test_playing_by_keyboard_and_with_less_motion(html: str, document: Document) -> None:
    assert document.tags["button"] == document.tags["select"] == 2
    assert html.count('type="range"') == html.count('aria-label="Time"') == 2
    assert "prefers-reduced-motion" in html
    assert "@media print{.controls{display:none}}" in html
    # Without a script there is no control that does nothing; stills stand below.
    assert html.count('<figure class="player" hidden>') == 2


def test_numbers_are_the_motions(document: Document) -> None:
    for planned in (plans.missing(), plans.stepping()):
        assert f"{planned.motion.duration:.1f}" in document.text
        reached = sum(one.reached for one in planned.targets)
        assert f"{reached} of {len(planned.targets)}" in document.text
    away = 1e3 * plans.missing().motion.path.nearest[2]
    assert f"motion_001: out of reach: landmark 3 ({away:.1f} mm off)." in document.text
    assert "WARN" in document.text


def test_what_could_not_be_planned_is_told_with_its_reason() -> None:
    motions = [plans.reaching()]
    missing = Unplanned("motion_002", DoubleSupport(0.0, -0.39, 0.0), HOSTILE)
    found = verdict(motions, [missing])
    assert found.level == "FAIL"
    assert found.meaning == "1 of 2 motions could not be planned."
    drawn = [motion_pictures(motion) for motion in motions]
    html = render(plan_page(motions, drawn, [missing]))
    assert "<script>alert" not in html
    text = read(html).text
    assert text.count(HOSTILE) == 2
    assert "y −390 mm" in text.replace("\N{NO-BREAK SPACE}", " ")


def test_a_plan_is_small(html: str) -> None:
    """Five motions stay well below 3 MB."""
    assert len(html) < 2 * 500_000


def test_verdicts() -> None:
    assert verdict([plans.reaching()]).level == "PASS"
    planned = plans.reaching()
    first, *others = planned.report.findings
    broken = Report((dataclasses.replace(first, excess=1.0), *others))
    found = verdict([dataclasses.replace(planned, report=broken), plans.missing()])
    assert found.level == "FAIL"
    assert [reason.level for reason in found.reasons] == ["FAIL", "WARN"]
    assert first.constraint in found.reasons[0].text


def test_names_cannot_enter_the_page() -> None:
    planned = plans.reaching()
    robot = dataclasses.replace(planned.robot, name=HOSTILE)
    motion = dataclasses.replace(planned.motion, name=HOSTILE)
    hostile = dataclasses.replace(planned, robot=robot, motion=motion)
    document = read(page(hostile))
    assert document.tags["script"] == 2
    assert "<script>alert(1)</script>" in document.text


def test_files_that_stand_by_themselves(tmp_path: Path) -> None:
    write_plan(tmp_path, [plans.missing()])
    assert sorted(file.name for file in tmp_path.iterdir()) == ["motion_001.svg", "plan.html"]
    text = (tmp_path / "motion_001.svg").read_text()
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg"
    assert "as planned" in root.attrib["aria-label"]
    assert len([one for one in root.iter(f"{SVG}svg") if one is not root]) == 5
    assert all(one.get("href", "#").startswith("#") for one in root.iter())
    assert "A plan, computed from the robot’s model; nothing was measured." in set(root.itertext())
    read((tmp_path / "plan.html").read_text())
    with pytest.raises(FileError):
        write_plan(tmp_path / "none", [plans.missing()])


def seen(player: Player) -> tuple[FloatArray, list[dict[str, Any]]]:
    """(F, P, 3) in millimetres, and the views, as the script gets them."""
    told = json.loads(player.data)
    count = len(told["lifted"])
    tracks = [
        [np.full(count, axis) if isinstance(axis, int | float) else np.array(axis) for axis in one]
        for one in told["points"]
    ]
    return np.array(tracks, dtype=np.float64).transpose(2, 0, 1), told["views"]


def through(views: list[dict[str, Any]], view: int, look: str) -> list[int]:
    """Points of the first shape of a look."""
    points: list[int] = next(one[2] for one in views[view]["shapes"] if one[0] == look)
    return points


def test_frames_follow_the_motion(player: Player) -> None:
    planned = plans.stepping()
    points, views = seen(player)
    count = len(points)
    assert count == int(np.ceil(planned.motion.duration * 10.0)) + 1
    samples = np.round(np.linspace(0, len(planned.motion.time) - 1, count)).astype(int)
    assert player.lifted == lifted(planned, samples)
    assert set(player.lifted) == {"-", "l"}
    com, cop = through(views, 0, "plumb")
    np.testing.assert_allclose(points[:, com], 1e3 * planned.com[samples], atol=0.06)
    np.testing.assert_allclose(points[:, cop, :2], 1e3 * planned.cop[samples], atol=0.06)
    assert not points[:, cop, 2].any()
    assert through(views, 2, "trace") == [cop]


@pytest.mark.parametrize("name", [plans.SECOND, "nao"])
def test_shapes_are_the_bodys(name: str) -> None:
    """Points of the body are told in whole millimetres."""
    planned = plans.planned(name, support=2)
    points, views = seen(animation(planned))
    first, body = points[0], moved(planned, 0)
    for side, (leg, sole) in enumerate((("left", "sole left"), ("right", "sole right"))):
        bones = 1e3 * body.bones[body.side == side].reshape(-1, 3)
        np.testing.assert_allclose(first[through(views, 0, leg)], bones, atol=0.51)
        for view in (0, 1, 2):
            corners = first[through(views, view, sole)]
            np.testing.assert_allclose(corners, 1e3 * body.soles[side], atol=0.51)
    capsule = first[through(views, 1, "capsule")]
    np.testing.assert_allclose(capsule, 1e3 * body.capsules[0], atol=0.51)
    texts = [one[3] for one in views[2]["shapes"] if one[1] == "text"]
    assert texts == [mark.numbers for mark in planned.marks]


@pytest.mark.parametrize("planned", [plans.stepping, plans.reaching], ids=["one foot", "both"])
def test_everything_is_within_its_view(planned: Callable[[], PlannedMotion]) -> None:
    player = animation(planned())
    points, _ = seen(player)
    for view in player.views:
        left, top, width, height = view.box
        drawn = sorted({point for _, _, through, _ in view.shapes for point in through})
        (across, right), (along, down) = view.right, view.down
        x, y = right * points[:, drawn, across], down * points[:, drawn, along]
        assert left <= x.min() < x.max() <= left + width
        assert top <= y.min() < y.max() <= top + height


def test_a_robot_without_capsules() -> None:
    planned = plans.reaching()
    bare = dataclasses.replace(planned.robot, capsules=(), collision_pairs=())
    slim = dataclasses.replace(planned, robot=bare)
    assert '"capsule"' in animation(planned).data
    assert '"capsule"' not in animation(slim).data
    for picture in motion_pictures(slim):
        ElementTree.fromstring(picture.svg)


def test_points_that_move_alike_are_one() -> None:
    points = PlayerPoints(2)
    still, moving = np.array([[0.1, 0.0, -1e-6]]), np.array([[[0.1, 0, 0]], [[0.2004, 0, 0]]])
    assert points.add(still) == points.add(still + 1e-5) == [0]
    assert points.add(moving) == [1]
    assert points.add(moving, 1) == [2]
    assert points.add(np.concatenate((moving[0], still))) == [0, 0]
    assert json.loads(points.data) == [[100, 0, 0], [[100, 200], 0, 0], [[100, 200.4], 0, 0]]
