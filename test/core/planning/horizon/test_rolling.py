from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.planning.bodies import Body
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.problem import HorizonProblem, HorizonSolution, Scene
from shoecal_core.planning.horizon.rolling import (
    Path,
    PlanningCanceledError,
    PlanningError,
    Progress,
    Pursuit,
    RollingHorizon,
)
from shoecal_core.planning.landmarks import Contour, sensing_hull
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.posture import StanceSolver
from shoecal_core.planning.segment import MotionSegment, cop_segment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import interpolated_poses, lifted
from shoecal_core.robot.double_support import DoubleSupport

SETTINGS = PlannerSettings(
    landmark_radius=0.004, progress_min=0.0002, progress_patience=3, horizon=6
)
TARGETS = np.array([[0.05, 0.0], [0.05, 0.05], [0.0, 0.05]])
SUPPORT = DoubleSupport(0.02, -0.125, 0.15)


def test_close_enough_takes_the_next() -> None:
    pursuit = Pursuit(TARGETS, np.zeros(2), SETTINGS)
    assert not pursuit.observe(np.array([0.045, 0.0]))
    assert pursuit.observe(np.array([0.0465, 0.0]))
    assert pursuit.index == 1
    assert pursuit.nearest[0] == pytest.approx(0.0035)
    # Taken anew, to the new landmark.
    assert pursuit.distance == pytest.approx(np.hypot(0.0035, 0.05))


def test_no_progress_takes_the_next() -> None:
    pursuit = Pursuit(TARGETS, np.zeros(2), SETTINGS)
    due = [pursuit.observe(np.array([x, 0.0])) for x in (0.01, 0.0101, 0.0102, 0.0103)]
    assert due == [False, False, False, True]
    assert pursuit.nearest[0] == pytest.approx(0.0397)


def test_progress_makes_patient_again() -> None:
    pursuit = Pursuit(TARGETS, np.zeros(2), SETTINGS)
    for x in (0.0, 0.0, 0.01, 0.01, 0.01):
        assert not pursuit.observe(np.array([x, 0.0]))
    assert pursuit.observe(np.array([0.01, 0.0]))


def test_moving_away_at_once_after_a_switch_is_not_yet_no_progress() -> None:
    """The way to the old landmark may lead away from the new one for a step."""
    pursuit = Pursuit(TARGETS, np.array([0.04, -0.02]), SETTINGS)
    pursuit.observe(np.array([0.05, -0.003]))
    assert pursuit.index == 1
    assert not pursuit.observe(np.array([0.05, -0.005]))


def test_the_last_one_is_pursued_too() -> None:
    pursuit = Pursuit(TARGETS[:1], np.zeros(2), SETTINGS)
    assert not pursuit.done
    for x in (0.01, 0.02, 0.03):
        pursuit.observe(np.array([x, 0.0]))
        assert not pursuit.done
    pursuit.observe(np.array([0.049, 0.0]))
    assert pursuit.done
    assert pursuit.distance == 0.0


def test_lean_and_height_count_by_their_weights() -> None:
    targets = np.array([[0.0, 0.0, 0.1, 0.0, 0.3]])
    weights = np.array([1.0e4, 1.0e4, 1.0e2, 1.0e2, 4.0e4])
    now = np.array([0.003, 0.0, 0.1, 0.04, 0.302])
    pursuit = Pursuit(targets, now, SETTINGS, weights)
    assert pursuit.distance == pytest.approx(np.hypot(0.003, np.hypot(0.1 * 0.04, 2.0 * 0.002)))
    alone = Pursuit(targets, now, SETTINGS)
    assert alone.distance == pytest.approx(0.003)


def test_paths_that_follow_each_other_are_one() -> None:
    def path(states: list[float], switches: list[int], nearest: list[float]) -> Path:
        return Path(
            states=np.array(states)[:, None],
            targets=np.array(nearest)[:, None] * [1.0, 2.0],
            nearest=np.array(nearest),
            switches=np.array(switches),
            statuses=("Solved",) * len(states),
            solve_times=np.ones(len(states)),
        )

    whole = Path.joined([path([0.0, 1.0, 2.0], [1, 2], [5.0, 6.0]), path([2.0, 3.0], [1], [7.0])])
    np.testing.assert_array_equal(whole.states[:, 0], [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(whole.switches, [1, 2, 3])
    np.testing.assert_array_equal(whole.nearest, [5.0, 6.0, 7.0])
    assert whole.targets.shape == (3, 2)
    assert len(whole.statuses) == len(whole.solve_times) == 5


def scene_of(body: Body) -> tuple[FloatArray, Scene]:
    start = StanceSolver(body.legs, SETTINGS).solve(SUPPORT)
    hull = sensing_hull(body.robot, SUPPORT)
    pose = FootPose.of(SUPPORT)
    return start, Scene.of(hull, SETTINGS.stability_margin, pose, body.robot.posture)


@pytest.fixture(scope="module")
def collocation(nao: Body) -> Collocation:
    return Collocation(nao.legs, SETTINGS)


@pytest.fixture(scope="module")
def ipopt(collocation: Collocation) -> IpoptSolver:
    return IpoptSolver(collocation)


def segment_of(places: FloatArray) -> MotionSegment:
    return cop_segment("landmarks", places, FootPose.of(SUPPORT), SETTINGS)


def two_targets(nao: Body) -> FloatArray:
    contour = Contour.of(nao.robot, SUPPORT)
    cop = nao.legs.cop(nao.robot.from_legs(scene_of(nao)[0])[None])[0]
    # Well inside: how near the rim a motion comes is another matter.
    places = cop + 0.8 * (contour.targets(cop)[:2] - cop)
    return StanceSolver(nao.legs, SETTINGS).within_reach(
        FootPose.of(SUPPORT), places, nao.robot.posture
    )


def test_reaches_landmarks_in_turn(nao: Body, collocation: Collocation, ipopt: IpoptSolver) -> None:
    start, scene = scene_of(nao)
    targets = two_targets(nao)
    told: list[Progress] = []
    path = RollingHorizon(collocation, [ipopt]).roll(
        start, segment_of(targets), nao.robot.posture, progress=told.append
    )
    np.testing.assert_array_equal(path.states[0], start)
    assert np.all(path.nearest < SETTINGS.landmark_radius)
    cops = collocation.evaluate(path.states, scene).cop
    for target, switch in zip(targets, path.switches, strict=True):
        assert np.linalg.norm(cops[switch] - target) < SETTINGS.landmark_radius
    assert path.switches[-1] == len(path.states) - 1
    assert len(path.statuses) == len(path.solve_times) == len(told)
    assert [entry.landmark for entry in told] == sorted(entry.landmark for entry in told)
    assert told[-1].landmarks == 2
    again = RollingHorizon(collocation, [ipopt]).roll(start, segment_of(targets), nao.robot.posture)
    np.testing.assert_array_equal(path.states, again.states)


def test_an_unreachable_landmark_is_given_up(
    nao: Body, collocation: Collocation, ipopt: IpoptSolver
) -> None:
    start, scene = scene_of(nao)
    targets = np.array([[0.3, -0.06], two_targets(nao)[0]])
    path = RollingHorizon(collocation, [ipopt]).roll(start, segment_of(targets), nao.robot.posture)
    assert path.nearest[0] > 0.2
    assert path.nearest[1] < SETTINGS.landmark_radius
    cops = collocation.evaluate(path.states, scene).cop
    assert np.all(scene.beyond(cops) <= scene.offsets + 1e-6)


def test_cancelled(nao: Body, collocation: Collocation, ipopt: IpoptSolver) -> None:
    start, _ = scene_of(nao)
    answers = iter([False, False, True])
    horizon = RollingHorizon(collocation, [ipopt])
    with pytest.raises(PlanningCanceledError):
        horizon.roll(
            start, segment_of(two_targets(nao)), nao.robot.posture, canceled=lambda: next(answers)
        )


@dataclasses.dataclass
class Failing:
    """A solver that finds nothing."""

    collocation: Collocation
    states: FloatArray | None = None
    calls: int = 0

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        self.calls += 1
        states = guess + 0.1 if self.states is None else np.tile(problem.start, (len(guess), 1))
        return self.collocation.certified(problem, states, "Failed", 1, False)


def test_the_next_solver_steps_in(nao: Body, collocation: Collocation, ipopt: IpoptSolver) -> None:
    start, _ = scene_of(nao)
    failing = Failing(collocation)
    path = RollingHorizon(collocation, [failing, ipopt]).roll(
        start, segment_of(two_targets(nao)[:1]), nao.robot.posture
    )
    assert path.nearest[0] < SETTINGS.landmark_radius
    # From the guess and from standing still, which is the first guess.
    assert failing.calls == 2 * len(path.statuses) - 1


def test_a_shorter_way_is_taken_where_the_whole_one_fails(
    nao: Body, collocation: Collocation, ipopt: IpoptSolver
) -> None:
    """A solver that only dares to aim at places near by."""

    class Timid:
        def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
            cop = collocation.evaluate(problem.start[None], problem.scene.first).cop[0]
            if np.linalg.norm(problem.aim.targets[0, :2] - cop) > 0.02:
                return collocation.certified(problem, guess + 0.1, "Too_Far", 1, False)
            return ipopt.solve(problem, guess)

    start, _ = scene_of(nao)
    segment = segment_of(two_targets(nao))
    path = RollingHorizon(collocation, [Timid()]).roll(start, segment, nao.robot.posture)
    assert np.all(path.nearest < SETTINGS.landmark_radius)
    assert "Too_Far" in path.statuses


def test_a_foot_that_cannot_go_on_is_told(nao: Body, collocation: Collocation) -> None:
    start, _ = scene_of(nao)
    pose = FootPose.of(SUPPORT)
    way = interpolated_poses(pose, lifted(pose, SupportPhase.LEFT, 0.01), SupportPhase.LEFT, 6)
    target, weights = np.zeros((1, 5)), SETTINGS.task_weights
    segment = MotionSegment("lift", target, weights, way, SupportPhase.LEFT)
    with pytest.raises(PlanningError, match="part 'lift': the foot cannot go on after state 0"):
        RollingHorizon(collocation, [Failing(collocation)]).roll(start, segment, nao.robot.posture)


def test_solvers_that_always_fail_end_with_an_error(nao: Body, collocation: Collocation) -> None:
    start, _ = scene_of(nao)
    failing = Failing(collocation)
    with pytest.raises(PlanningError, match="no motion towards any of 2 landmarks"):
        RollingHorizon(collocation, [failing]).roll(
            start, segment_of(two_targets(nao)), nao.robot.posture
        )
    # Both targets, in three lengths of the way, from the one guess: standing still.
    assert failing.calls == 6


def test_a_solver_that_stands_still_ends_by_no_progress(
    nao: Body, collocation: Collocation
) -> None:
    start, _ = scene_of(nao)
    standing = Failing(collocation, states=start)
    path = RollingHorizon(collocation, [standing]).roll(
        start, segment_of(two_targets(nao)), nao.robot.posture
    )
    assert len(path.states) == 1 + 2 * SETTINGS.progress_patience
    np.testing.assert_array_equal(path.states, np.tile(start, (len(path.states), 1)))


def test_steps_are_bounded(nao: Body, ipopt: IpoptSolver) -> None:
    bounded = dataclasses.replace(SETTINGS, steps_max=4)
    collocation = Collocation(nao.legs, bounded)
    start, _ = scene_of(nao)
    path = RollingHorizon(collocation, [ipopt]).roll(
        start, segment_of(two_targets(nao)), nao.robot.posture
    )
    assert 4 <= len(path.states) - 1 <= 5
    assert np.isinf(path.nearest[-1]) or len(path.switches) < 2


def test_nothing_to_pursue(nao: Body, collocation: Collocation, ipopt: IpoptSolver) -> None:
    start, _ = scene_of(nao)
    path = RollingHorizon(collocation, [ipopt]).roll(
        start, segment_of(np.zeros((0, 2))), nao.robot.posture
    )
    np.testing.assert_array_equal(path.states, start[None])


def test_no_solver(collocation: Collocation) -> None:
    with pytest.raises(PlanningError, match="at least one"):
        RollingHorizon(collocation, [])
