from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import load_body
from core.planning.motions import SETTINGS, SUPPORTS
from core.planning.test_support_phase import supports
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.segment import MotionSegment, cop_segment, in_left, in_standing
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport

POSE = FootPose.of(SUPPORTS[0])
ROBOT = load_body("nao").robot
heights = st.floats(-0.03, 0.03)
tasks = st.tuples(
    *[st.floats(-0.2, 0.2)] * 2, *[st.floats(-0.3, 0.3)] * 2, st.floats(0.1, 0.4)
).map(np.array)


def raised(support: DoubleSupport, height: float) -> FootPose:
    """The right sole that much above the left one."""
    pose = FootPose.of(support)
    return FootPose(pose.rotation, pose.translation + np.array([0.0, 0.0, height]))


@given(support=supports, height=heights, at=tasks, support_phase=st.sampled_from(SupportPhase))
def test_there_and_back(
    support: DoubleSupport, height: float, at: FloatArray, support_phase: SupportPhase
) -> None:
    pose = raised(support, height)
    seen = in_standing(at, pose, support_phase)
    np.testing.assert_allclose(in_left(seen, pose, support_phase), at, atol=1e-12)
    np.testing.assert_allclose(
        in_standing(in_left(at, pose, support_phase), pose, support_phase), at, atol=1e-12
    )


@given(support=supports, height=heights, at=tasks)
def test_the_right_soles_frame(support: DoubleSupport, height: float, at: FloatArray) -> None:
    """As matrices have it: places move with the frame, directions turn, heights count from it."""
    pose = raised(support, height)
    seen = in_standing(at, pose, SupportPhase.RIGHT)
    place = pose.inverse.rotation @ [*at[:2], at[4]] + pose.inverse.translation
    np.testing.assert_allclose([*seen[:2], seen[4]], place, atol=1e-12)
    lean = pose.inverse.rotation @ [*at[2:4], 0.0]
    np.testing.assert_allclose([*seen[2:4], 0.0], lean, atol=1e-12)
    for support_phase in (SupportPhase.LEFT, SupportPhase.BOTH):
        np.testing.assert_array_equal(in_standing(at, pose, support_phase), at)


def swing(support_phase: SupportPhase, count: int = 5) -> MotionSegment:
    poses = tuple(raised(SUPPORTS[0], 0.002 * index) for index in range(count))
    target = np.array([[0.02, 0.01, 0.0, 0.05, 0.3]])
    return MotionSegment("swing", target, SETTINGS.task_weights, poses, support_phase)


def test_poses_go_on_as_the_last_one() -> None:
    segment = swing(SupportPhase.LEFT)
    assert segment.moving
    assert [segment.pose(index) for index in (0, 4, 9)] == [
        segment.foot_poses[0], segment.foot_poses[4], segment.foot_poses[4],
    ]  # fmt: skip
    assert not cop_segment("hold", np.zeros((1, 2)), POSE, SETTINGS).moving


@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_every_state_of_a_horizon_keeps_its_own_pose(support_phase: SupportPhase) -> None:
    segment = swing(support_phase)
    scene = segment.scene(ROBOT, SETTINGS, ROBOT.posture, 2)
    poses = [segment.pose(3 + index) for index in range(SETTINGS.horizon)]
    np.testing.assert_allclose(scene.foot_poses, [pose.parameters for pose in poses])
    np.testing.assert_allclose(scene.shares, [support_phase.share] * len(poses))
    for pose, normals, offsets in zip(poses, scene.normals, scene.offsets, strict=True):
        # Inside by the margin and a little less, beyond by the margin and a little more.
        polygon = support_phase.polygon(ROBOT, pose)
        for nearer, inside in ((1e-4, True), (-1e-4, False)):
            for corner in polygon.buffer(
                -SETTINGS.one_foot_margin - nearer, join_style="mitre"
            ).exterior.coords:
                assert bool(np.all(normals @ corner <= offsets)) is inside


def test_standing_on_both_feet_one_scene_serves_all_states() -> None:
    segment = cop_segment("landmarks", np.zeros((1, 2)), POSE, SETTINGS)
    scene = segment.scene(ROBOT, SETTINGS, ROBOT.posture, 7)
    assert len(scene.foot_poses) == 1
    assert len(segment.aim(segment.targets[0], SETTINGS.horizon, 7).targets) == 1


@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_the_aim_stays_with_the_foot_that_stands(support_phase: SupportPhase) -> None:
    """Its left sole rises: seen from there the same place sinks."""
    segment = swing(support_phase)
    aim = segment.aim(segment.targets[0], 3, 1)
    seen = [
        in_standing(row, segment.pose(2 + index), support_phase)
        for index, row in enumerate(np.broadcast_to(aim.targets, (3, 5)))
    ]
    np.testing.assert_allclose(seen, np.tile(segment.targets[0], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(segment.local(aim.targets[0], 2), segment.targets[0], atol=1e-12)
    left = FootPose.of(SUPPORTS[0]).support.right_to_left(segment.targets[:, :2])
    np.testing.assert_allclose(
        segment.left_targets,
        left if support_phase is SupportPhase.RIGHT else segment.targets[:, :2],
    )


def test_parts_that_cannot_be() -> None:
    with pytest.raises(ShoecalError, match=r"part 'swing' .* no pose"):
        MotionSegment("swing", np.zeros((1, 5)), SETTINGS.task_weights, ())
    with pytest.raises(ShoecalError, match=r"part 'swing' moves a foot but pursues nothing"):
        MotionSegment("swing", np.zeros((0, 5)), SETTINGS.task_weights, (POSE, POSE))
