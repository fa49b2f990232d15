"""Whatever a planner is asked, it ends: in a checked motion, or in one line that tells the cure."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.planning.bodies import load_body
from core.planning.motions import SETTINGS, planner_of
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import MARGIN_KEPT, check_motion
from shoecal_core.planning.horizon.problem import HorizonProblem, HorizonSolution, Solver
from shoecal_core.planning.horizon.rolling import PlanningError, RollingHorizon
from shoecal_core.planning.horizon.sqp import SqpSolver
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner, StartError
from shoecal_core.planning.posture import StanceSolver, UnreachableError
from shoecal_core.planning.segment import MotionSegment, cop_segment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.settings import SettingError

NAMES = ("nao", "wren")


def neutral(name: str) -> DoubleSupport:
    return DoubleSupport(*(float(v) for v in load_body(name).robot.support_range.neutral))


def stance_of(name: str) -> FloatArray:
    return planner_of(name).stance(neutral(name))


def planner_with(name: str, **changes: float | str) -> Planner:
    return Planner(load_body(name).robot, dataclasses.replace(SETTINGS, **changes))  # type: ignore[arg-type]


def certified(planner: Planner, motion: Motion) -> Motion:
    """A motion that keeps everything and is at rest at both ends."""
    assert check_motion(planner.legs, motion, planner.settings).kept
    np.testing.assert_allclose(motion.velocities[[0, -1]], 0.0, atol=1e-6)
    assert np.all(np.isfinite(motion.positions))
    return motion


def motion_or_cure(
    plan: Callable[[], Motion], error: type[ShoecalError], cure: str
) -> Motion | None:
    """The motion, or None where the one error that may be raised tells its cure."""
    try:
        return plan()
    except error as found:
        if cure not in str(found):
            raise
        return None


def going(name: str, places: FloatArray) -> tuple[MotionSegment, ...]:
    """Places (L, 2) for the CoP from the neutral stance on [m]."""
    return (cop_segment("places", places, FootPose.of(neutral(name)), SETTINGS),)


# ---- where it starts --------------------------------------------------------------------------


def straight(robot: Robot) -> FloatArray:
    """InitialStance with straight legs: the zero pose of both robots."""
    angles = robot.posture.copy()
    angles[[*robot.legs, *(shared.joint for shared in robot.shared)]] = 0.0
    return angles


@pytest.mark.parametrize("name", NAMES)
def test_straight_legs(name: str) -> None:
    planner = planner_of(name)
    motion = certified(planner, planner.plan_from(straight(planner.legs.robot)))
    assert np.sum(motion.path.nearest < SETTINGS.landmark_radius) >= 3
    for knee in planner.legs.knees:
        bend = abs(motion.path.states[-1, knee.column] - knee.straight)
        assert bend > SETTINGS.knee_margin - 1e-5


@pytest.mark.parametrize("side", [(1.0, 0.0), (-1.0, 0.0)])
@pytest.mark.parametrize("name", NAMES)
def test_a_cop_outside_the_margin(name: str, side: tuple[float, float]) -> None:
    planner, support = planner_of(name), neutral(name)
    robot = planner.legs.robot
    hull = sensing_hull(robot, support)
    middle = planner.legs.cop(stance_of(name)[None])[0]
    ray = shapely.LineString([middle, middle + np.array(side)])
    edge = np.array(ray.intersection(hull.exterior).coords[0])
    # Put there by hand, whatever load and tilt then are.
    anyhow = dataclasses.replace(robot, friction=2.0, tilt_max=1.5)
    solver = StanceSolver(Legs(anyhow), dataclasses.replace(SETTINGS, load_share=0.0))
    start = robot.from_legs(solver.solve(support, edge - 0.001 * np.array(side)))
    motion = certified(planner, planner.plan_from(start))
    distances = np.asarray(shapely.distance(hull.exterior, shapely.points(motion.cop)))
    assert distances[0] < SETTINGS.stability_margin
    assert distances[len(distances) // 2 :].min() > 0.8 * SETTINGS.stability_margin
    assert np.all(motion.path.nearest < SETTINGS.landmark_radius)


STRICT: dict[str, dict[str, float | str]] = {
    "a joint beyond its margin": {"joint_margin": 0.3},
    "legs straighter than wanted": {"knee_margin": 0.9},
    "torques above their share": {"torque_share": 0.05},
    "a CoP far outside the margin": {"stability_margin": 0.035},
}  # fmt: skip


@pytest.mark.parametrize("case", STRICT)
def test_starts_outside_a_constraint(case: str) -> None:
    """As measured after settings have become stricter."""
    planner, start = planner_with("nao", **STRICT[case]), stance_of("nao")
    motion = certified(planner, planner.plan_from(start))
    np.testing.assert_allclose(motion.positions[0], start, atol=1e-12)
    assert motion.path.nearest.shape == (5,)


def test_a_stance_that_cannot_be_had_is_told() -> None:
    planner = planner_with("nao", torque_share=0.05)
    with pytest.raises(UnreachableError, match=r"torque too large .* or torque_share"):
        planner.plan(neutral("nao"))


offsets = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@settings(max_examples=8, derandomize=True)
@given(generator=offsets)
def test_random_starts(generator: np.random.Generator) -> None:
    planner, stance = planner_of("nao"), stance_of("nao")
    start = stance + generator.uniform(-0.03, 0.03, len(stance))
    for shared in planner.legs.robot.shared:
        start[shared.joint] = shared.ratio * start[shared.leader]
    motion = motion_or_cure(lambda: planner.plan_from(start), StartError, "check the joint offsets")
    if motion is not None:
        certified(planner, motion)


def test_feet_on_each_other() -> None:
    with pytest.raises(UnreachableError, match=r"outlines of the feet overlap .* farther from"):
        planner_of("wren").plan(DoubleSupport(0.0, -0.06, 0.0))


# ---- where it shall go ------------------------------------------------------------------------


FAR: dict[str, list[list[float]]] = {
    "on one side, then on the other": [[0.5, 0.0], [-0.5, -0.05]],
    # Alone: from a stance at the edge of its reach every solver takes long to give it up.
    "farther than numbers like": [[1e6, 1e6]],
}


@pytest.mark.parametrize("case", FAR)
def test_places_out_of_reach(case: str) -> None:
    """Each is given up when it comes no nearer; the last is reached all the same."""
    name = "wren"
    planner, start = planner_of(name), stance_of(name)
    near = planner.legs.cop(start[None])[0] + [0.0, 0.01]
    places = np.array([*FAR[case], near])
    motion = certified(planner, planner.follow(start, "far", going(name, places)))
    assert np.all(motion.path.nearest[:-1] > 0.3)
    assert motion.path.nearest[-1] < SETTINGS.landmark_radius
    assert len(motion.path.states) < 200


@pytest.mark.parametrize("count", [0, 1, 5])
def test_nowhere_to_go(count: int) -> None:
    planner, start = planner_of("wren"), stance_of("wren")
    here = np.tile(planner.legs.cop(start[None])[0], (count, 1))
    motion = certified(planner, planner.follow(start, "here", going("wren", here)))
    assert np.all(motion.path.nearest < 1e-6)
    assert np.abs(motion.positions - start).max() < 1e-3


def test_nothing_to_do() -> None:
    with pytest.raises(PlanningError, match="'idle' has no parts; give at least one"):
        planner_of("wren").follow(stance_of("wren"), "idle", ())


def test_places_that_are_none() -> None:
    with pytest.raises(ShoecalError, match="targets that are not finite numbers"):
        going("wren", np.array([[np.nan, 0.0]]))


def test_what_is_not_pursued_at_all_is_refused() -> None:
    with pytest.raises(SettingError, match="cop_weight_x: must be at least 1e-06"):
        PlannerSettings(cop_weight_x=0.0)


def sensing(robot: Robot, half: float) -> Robot:
    """The same robot with square sensing polygons of half that width [m]."""
    corners = half * np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    feet = tuple(dataclasses.replace(foot, sensing_polygon=corners) for foot in robot.feet)
    return dataclasses.replace(robot, feet=(feet[0], feet[1]))


def test_tiny_polygons() -> None:
    robot = load_body("wren").robot
    planner = Planner(sensing(robot, SETTINGS.stability_margin + 5e-4), SETTINGS)
    motion = certified(planner, planner.plan(neutral("wren")))
    assert np.all(motion.path.nearest < 2.0 * SETTINGS.landmark_radius)
    with pytest.raises(SettingError, match=r"stability_margin: .* leaves nothing .* lower it"):
        Planner(sensing(robot, 1e-3), SETTINGS).plan(neutral("wren"))


# ---- parallel capsules ------------------------------------------------------------------------


def fat_thighs(name: str, gap: float) -> Robot:
    """With thighs, parallel in the neutral stance, so thick that they are that far apart [m]."""
    robot = load_body(name).robot
    pair = next(
        (a, b) for a, b in robot.collision_pairs
        if all("thigh" in robot.capsules[index].name for index in (a, b))
    )  # fmt: skip
    row = robot.collision_pairs.index(pair)
    distance = float(track(robot, stance_of(name)[None]).distances[0, row])
    capsules = tuple(
        dataclasses.replace(capsule, radius=capsule.radius + (distance - gap) / 2.0)
        if index in pair
        else capsule
        for index, capsule in enumerate(robot.capsules)
    )
    return dataclasses.replace(robot, capsules=capsules, collision_pairs=(pair,))


def test_parallel_thighs_that_nearly_touch() -> None:
    planner = Planner(fat_thighs("wren", 0.0035), SETTINGS)
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    distances = track(planner.legs.robot, motion.positions).distances
    assert distances.min() > MARGIN_KEPT * SETTINGS.capsule_clearance
    assert len(motion.path.states) < 200


def test_parallel_thighs_nearer_than_allowed() -> None:
    """Above feet that stay they hardly get apart: that is told, with the cure."""
    planner = Planner(fat_thighs("wren", 0.001), SETTINGS)
    told = "'left_thigh' and 'right_thigh' are 1.0 mm apart, capsule_clearance is 3 mm"
    motion = motion_or_cure(lambda: planner.plan_from(stance_of("wren")), PlanningError, told)
    if motion is not None:
        certified(planner, motion)


# ---- solvers that fail ------------------------------------------------------------------------


@dataclass
class Spoiled:
    """A solver whose answers something happens to.

    Attributes:
        planner: whose problem it is.
        how: what happens to the states (N, k) that the fast solver finds.
        honest: whether it certifies them.
        calls: how often it was asked.
    """

    planner: Planner
    how: Callable[[HorizonProblem, FloatArray], FloatArray]
    honest: bool = True
    calls: int = 0

    def __post_init__(self) -> None:
        self._collocation = self.planner.horizon.collocation
        self._solver = SqpSolver(self._collocation)

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        self.calls += 1
        states = self.how(problem, self._solver.solve(problem, guess).states)
        found = self._collocation.certified(problem, states, "Spoiled", 1, True)
        if self.honest:
            return found
        return dataclasses.replace(found, violation=0.0, converged=True)


@pytest.fixture
def planner(monkeypatch: pytest.MonkeyPatch) -> Planner:
    """One whose solvers may be replaced."""
    made = planner_of("wren")
    monkeypatch.setattr(made, "horizon", made.horizon)
    return made


def use(planner: Planner, *solvers: Solver) -> None:
    planner.horizon = RollingHorizon(planner.horizon.collocation, solvers)


def raising(_: HorizonProblem, __: FloatArray) -> FloatArray:
    raise RuntimeError("Error in Function::call for 'program': out of memory")


FAILURES: dict[str, Callable[[HorizonProblem, FloatArray], FloatArray]] = {
    "far off": lambda _, states: states + 1.0,
    "a little off": lambda _, states: states + 1e-3,
    "no numbers": lambda _, states: np.full_like(states, np.nan),
    "infinite": lambda _, states: np.full_like(states, np.inf),
    "raises": raising,
}


@pytest.mark.parametrize("case", FAILURES)
def test_solvers_that_always_fail(case: str, planner: Planner) -> None:
    spoiled = Spoiled(planner, FAILURES[case])
    use(planner, spoiled)
    with pytest.raises(PlanningError, match=r"no motion towards any of 5 landmarks .* lower the"):
        planner.plan_from(stance_of("wren"))
    # One guess, to stand still, for each of three parts of the way to each landmark.
    assert spoiled.calls == 3 * 5


@pytest.mark.parametrize("case", FAILURES)
def test_another_solver_steps_in(case: str, planner: Planner) -> None:
    use(planner, Spoiled(planner, FAILURES[case]), SqpSolver(planner.horizon.collocation))
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    assert np.all(motion.path.nearest < SETTINGS.landmark_radius)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_solver_that_fails_now_and_then(seed: int, planner: Planner) -> None:
    generator = np.random.default_rng(seed)

    def now_and_then(_: HorizonProblem, states: FloatArray) -> FloatArray:
        return states + float(generator.choice([0.0, 0.0, 0.3, np.nan]))

    spoiled = Spoiled(planner, now_and_then)
    use(planner, spoiled)
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    assert spoiled.calls <= 6 * len(motion.path.statuses)


def test_a_solver_that_stands_still(planner: Planner) -> None:
    use(planner, Spoiled(planner, lambda problem, states: np.tile(problem.start, (len(states), 1))))
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    assert len(motion.path.statuses) <= 5 * SETTINGS.progress_patience


def test_a_solver_that_lies(planner: Planner) -> None:
    """Whatever it claims, no motion that violates a constraint is released."""
    use(planner, Spoiled(planner, FAILURES["no numbers"], honest=False))
    motion = motion_or_cure(
        lambda: planner.plan_from(stance_of("wren")), PlanningError, "lower the margins"
    )
    if motion is not None:
        certified(planner, motion)


# ---- few iterations, short horizons -----------------------------------------------------------


HURRIED: dict[str, dict[str, float | str]] = {
    "one iteration": {"iterations": 1},
    "one iteration of the reference": {"iterations": 1, "solver": "ipopt"},
    "two states": {"horizon": 2},
    "one step": {"steps_max": 1},
}  # fmt: skip


@pytest.mark.parametrize("case", HURRIED)
def test_hurried_planners(case: str) -> None:
    planner = planner_with("wren", **HURRIED[case])
    motion = motion_or_cure(
        lambda: planner.plan(neutral("wren")), PlanningError, "lower the margins"
    )
    if motion is not None:
        certified(planner, motion)


def test_what_fails_its_check_is_planned_in_finer_steps(planner: Planner) -> None:
    use(planner, Spoiled(planner, FAILURES["a little off"], honest=False))
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    moves = np.abs(np.diff(motion.path.states, axis=0))
    assert np.all(moves <= planner.horizon.collocation.transition / 2.0 + 1e-9)
    assert np.all(motion.path.nearest < SETTINGS.landmark_radius)


def test_what_finer_steps_do_not_mend_is_planned_in_finer_ones_still(
    planner: Planner, monkeypatch: pytest.MonkeyPatch
) -> None:
    use(planner, Spoiled(planner, FAILURES["a little off"], honest=False))
    monkeypatch.setitem(vars(planner), "_finer", planner.horizon)
    motion = certified(planner, planner.plan_from(stance_of("wren")))
    moves = np.abs(np.diff(motion.path.states, axis=0))
    assert np.all(moves <= planner.horizon.collocation.transition / 4.0 + 1e-9)
