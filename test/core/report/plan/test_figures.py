"""Figures of planned motions: what stands in them is what was planned."""

from __future__ import annotations

import dataclasses
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from core.report import plans
from core.report.pages import read_svg
from shoecal_core.errors import ShapeError
from shoecal_core.planning.checking.findings import ConstraintMargin
from shoecal_core.report import palette
from shoecal_core.report.figures.margins import at_least, margin_text, margins, short_name, used
from shoecal_core.report.figures.motion import leg_keys
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.figures.support_plan import support_plan, swing
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.plan.figures import angles, motion_pictures, torques

MOTIONS = {"reaching": plans.reaching, "missing": plans.missing, "stepping": plans.stepping}


def words(svg: str) -> list[str]:
    return [text for text in read_svg(svg).itertext() if text.strip()]


@pytest.mark.parametrize("name", list(MOTIONS))
def test_every_figure_tells_its_units(name: str) -> None:
    pictures = motion_pictures(MOTIONS[name]())
    assert len(pictures) == 5
    axes = {
        "Seen from above": ("x, forward (mm)", "y, to the left (mm)"),
        "Margins kept": ("part of the limit used", "limit of the check"),
        "Joint angles within their limits": ("time (s)",),
        "Torques that hold the posture": ("time (s)",),
        "On its way": ("from the right", "from the front"),
    }
    for picture in pictures:
        found = words(picture.svg)
        assert set(axes[picture.title]) <= set(found)


def test_landmarks_stand_in_the_order_of_pursuit() -> None:
    found = words(support_plan(plans.reaching()))
    numbers = ("1", "2", "3", "4", "5")
    assert tuple(text for text in found if text in numbers) == numbers
    assert "not reached: distance" not in found


def test_a_landmark_out_of_reach_is_told_with_its_distance() -> None:
    planned = plans.missing()
    away = 1e3 * planned.motion.path.nearest[2]
    found = words(support_plan(planned))
    assert f"{away:.1f} mm" in found
    assert {"not reached: distance", "1", "2", "3", "4", "5"} <= set(found)
    assert f"landmark 3: {away:.1f} mm off" in str(
        read_svg(support_plan(planned)).get("aria-label")
    )


def test_one_that_was_never_pursued() -> None:
    planned = plans.missing()
    path = planned.motion.path
    nearest = np.append(path.nearest[:-1], math.inf)
    cut = dataclasses.replace(path, nearest=nearest, switches=path.switches[:-1])
    short = dataclasses.replace(planned, motion=dataclasses.replace(planned.motion, path=cut))
    assert "never pursued" in words(support_plan(short))


def test_the_hull_of_both_sensing_polygons() -> None:
    planned = plans.reaching()
    (hull,) = planned.hulls
    support = planned.motion.support
    left, right = (foot.sensing_polygon for foot in planned.robot.feet)
    corners = np.vstack([left, support.right_to_left(right)])
    for corner in hull:
        assert np.linalg.norm(corners - corner, axis=1).min() < 1e-4


def test_a_lifted_foot_is_drawn() -> None:
    planned = plans.stepping()
    assert "lifted foot" in words(support_plan(planned))
    way = swing(planned, planned.stands[1])
    np.testing.assert_allclose(way.outline, planned.robot.feet[0].outline, atol=2e-3)
    assert np.linalg.norm(way.way[-1] - way.way[0]) < 2e-3


def test_joint_angles_and_torques_are_the_motions() -> None:
    planned = plans.reaching()
    robot = planned.robot
    found = words(angles(planned))
    assert set(robot.leg_names) <= set(found)
    for index in robot.legs:
        values = planned.motion.positions[:, index]
        room = min((values - robot.lower[index]).min(), (robot.upper[index] - values).min())
        assert f"{math.degrees(room):.1f}°" in found
    peak = 100.0 * planned.peak_torque[0]
    assert f"{peak:.0f}\N{NO-BREAK SPACE}%" in words(torques(planned))


def test_strips_need_one_value_a_moment() -> None:
    time = np.linspace(0.0, 1.0, 9)
    with pytest.raises(ShapeError):
        Strip("a", time, ((palette.TRUTH, time[1:]),), 0.0, 1.0, "1")


def finding(value: float, limit: float, *, least: bool, unit: str = "m") -> ConstraintMargin:
    excess = limit - value if least else value - limit
    return ConstraintMargin("a", unit, value, limit, excess, 1.0, "here")


@pytest.mark.parametrize(
    ("one", "share", "text"),
    [
        (finding(0.02, 0.004, least=True), 0.2, "20.00 mm, at least 4.00 mm"),
        (finding(0.002, 0.004, least=True), 2.0, "2.00 mm, at least 4.00 mm"),
        (finding(1.5, 3.0, least=False, unit="N m"), 0.5, "1.50 N m, at most 3.00 N m"),
        (finding(0.1, 0.05, least=False, unit="rad"), 2.0, "5.73°, at most 2.86°"),
        (finding(0.2, 0.4, least=False, unit=""), 0.5, "0.200, at most 0.400"),
        (finding(0.0, -1e-4, least=True), 0.0, "0.000 mm, at least \N{MINUS SIGN}0.100 mm"),
        (finding(-0.001, 0.004, least=True), math.inf, "\N{MINUS SIGN}1.00 mm, at least 4.00 mm"),
    ],
)
def test_parts_of_limits(one: ConstraintMargin, share: float, text: str) -> None:
    assert used(one) == pytest.approx(share)
    assert margin_text(one).replace("\N{NO-BREAK SPACE}", " ") == text
    assert at_least(one) == ("at least" in text)


def test_margins_tightest_first_and_violated_ones_marked() -> None:
    slack, tight = finding(0.1, 0.004, least=True), finding(0.0041, 0.004, least=True)
    broken = dataclasses.replace(finding(0.001, 0.004, least=True), constraint="broken")
    svg = margins([slack, broken, tight])
    found = [text for text in words(svg) if "mm, at" in text]
    assert [text[:4] for text in found] == ["1.00", "4.10", "100."]
    assert "var(--fail)" in svg


def test_margins_are_the_checks() -> None:
    planned = plans.reaching()
    label = str(read_svg(margins(planned.report.findings)).get("aria-label"))
    for one in planned.report.findings:
        assert short_name(one) in label
        assert margin_text(one) in label


@pytest.mark.filterwarnings("ignore:Glyph")
def test_any_joint_name_can_be_drawn() -> None:
    planned = plans.reaching()
    time = planned.motion.time
    label = "<b>&\"'</b>"
    strip = Strip(label, time, ((palette.TRUTH, time),), 0.0, time[-1], "1")
    assert label in words(strips([strip], leg_keys(), "edges", "told"))


def test_the_same_motion_is_the_same_bytes() -> None:
    planned = plans.missing()
    again = PlannedMotion(
        planned.label, planned.robot, planned.motion, planned.report, planned.settings
    )
    assert support_plan(planned) == support_plan(again)
    assert isinstance(read_svg(support_plan(planned)), ElementTree.Element)
