"""The body in the world along a motion: whoever carries stays, nothing jumps."""

from __future__ import annotations

import numpy as np
import pytest

from core.report import plans
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.report.plan.animation import on_foot
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.plan.figures import moved


def test_on_both_feet_the_world_is_the_left_sole() -> None:
    planned = plans.reaching()
    np.testing.assert_allclose(planned.cop, planned.motion.cop, atol=1e-9)
    assert [stand.feet for stand in planned.stands] == ["both"]
    rotation, place = planned.soles
    np.testing.assert_allclose(rotation[:, 0], np.eye(3)[None].repeat(len(place), 0), atol=1e-12)
    np.testing.assert_allclose(place[:, 1], np.tile(place[0, 1], (len(place), 1)), atol=1e-4)
    np.testing.assert_allclose(place[0, 1, :2], planned.motion.support.translation, atol=1e-6)


def test_the_phases_of_a_lifted_foot() -> None:
    planned = plans.stepping()
    assert [stand.feet for stand in planned.stands] == ["both", "right", "both"]
    assert planned.stands[0].begin == 0
    assert planned.stands[-1].end == len(planned.motion.time)
    lifting = [one for one in planned.motion.phases if one.support_phase is SupportPhase.RIGHT]
    alone = planned.stands[1]
    assert planned.motion.time[alone.begin] == pytest.approx(lifting[0].begin, abs=0.03)
    assert planned.motion.time[alone.end] == pytest.approx(lifting[-1].end, abs=0.03)


def test_who_carries_stays_and_nothing_jumps() -> None:
    planned = plans.stepping()
    alone = planned.stands[1]
    _, place = planned.soles
    right = place[alone.begin : alone.end, 1]
    np.testing.assert_allclose(right, np.tile(right[0], (len(right), 1)), atol=1e-9)
    height = place[alone.begin : alone.end, 0, 2]
    settings = planned.settings
    assert height.max() == pytest.approx(settings.lift, abs=1e-3)
    # No point of the plan is faster than joints are.
    assert np.abs(np.diff(place, axis=0)).max() < 0.002
    assert np.abs(np.diff(planned.com, axis=0)).max() < 0.002
    np.testing.assert_allclose(place[-1], place[0], atol=1e-3)


@pytest.mark.parametrize("planned", [plans.reaching, plans.stepping], ids=["both", "one foot"])
def test_the_body_stands_where_its_feet_do(planned: object) -> None:
    assert callable(planned)
    motion: PlannedMotion = planned()
    rotation, place = motion.soles
    for sample in np.linspace(0, len(place) - 1, 7).astype(int):
        body = moved(motion, int(sample))
        np.testing.assert_allclose(body.com, motion.com[sample], atol=1e-6)
        for side, foot in enumerate(motion.robot.feet):
            flat = np.column_stack((foot.outline, np.zeros(len(foot.outline))))
            there = flat @ rotation[sample, side].T + place[sample, side]
            np.testing.assert_allclose(body.soles[side], there, atol=1e-6)
            (seen,) = on_foot(motion, np.array([sample]), side, foot.outline)
            np.testing.assert_allclose(seen, there, atol=1e-6)


def test_one_foot_alone_carries_all() -> None:
    """The torques of single support, not those of a weight that is shared."""
    planned = plans.stepping()
    at = (planned.stands[1].begin + planned.stands[1].end) // 2
    names = [name for name in planned.robot.leg_names if name.startswith("left")]
    columns = [planned.robot.leg_names.index(name) for name in names]
    others = [index for index in range(len(planned.robot.leg_names)) if index not in columns]
    hanging = np.abs(planned.torque_share[at, columns]).max()
    assert hanging < 0.3 * np.abs(planned.torque_share[at, others]).max()
    share, joint = planned.peak_torque
    assert share == np.abs(planned.torque_share).max()
    assert joint in planned.robot.leg_names


def test_targets_stand_where_the_left_foot_was_when_they_were_told() -> None:
    """The first one leads the CoP over the right foot, the next one keeps it there."""
    planned = plans.stepping()
    first, lifted, lowered, back = planned.targets
    foot = planned.robot.feet[1]
    middle = planned.motion.support.right_to_left(foot.sensing_polygon).mean(axis=0)
    for one in (first, lifted, lowered):
        assert np.linalg.norm(one.place - middle) < 0.02
        assert one.cop_distance < planned.settings.landmark_radius
    np.testing.assert_allclose(back.place, planned.cop[0], atol=2e-3)
