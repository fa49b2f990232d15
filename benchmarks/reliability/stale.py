"""Joint angles or voltages stay away.

A real calibrator is in force beside a robot that stands on both feet or on one of them and tells
joints and voltages, each foot's in frames of their own, either first, with a period that is drawn
(5 to 100 ms). At a drawn moment joints, voltages or those of one foot stay away. From its last
message `/shoe/state` must say so, and not before, within 100 ms or three periods, whichever is
longer; without joint angles or one foot's voltages `/shoe/cop` and `/shoe/grf` must end, whose
point and torques are about one sole for both feet (on one foot, too), and those of a foot whose
voltages come go on; without voltages nothing is published; when all come again, so must everything.
A robot that itself was late may be told stale before. Beside it stands how long a reading takes to
`/shoe/left/grf`, at the worst of the same try: what the machine needs at any rate. Simulated: the
robot, of which only messages exist.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, WrenchStamped
from shoecal_msgs.msg import ShoeState
from shoecal_msgs.srv import SetCalibration

from reliability.live_world import World, live_world
from reliability.row import Progress, Result, Row
from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.sensing.shoe import FEET
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros, time_from_ros
from shoecal_ros.common.process import freeze_objects

AWAY: dict[str, tuple[str, Callable[[Any], bool], list[bool]]] = {
    "joints": ("joints", lambda state: state.joints_stale, [True, True]),
    "voltages": ("voltages", lambda state: _stale_feet(state) == [True, True], [False, False]),
    "left": (
        "voltages of the left foot",
        lambda state: _stale_feet(state) == [True, False],
        [False, True],
    ),
    "right": (
        "voltages of the right foot",
        lambda state: _stale_feet(state) == [False, True],
        [True, False],
    ),
}
"""What stays away, in words, how the state says so, and which foot's forces go on."""
PERIODS_NS = tuple(round(1e6 * ms) for ms in (5, 10, 20, 33, 50, 100))
WITHIN_S, WITHIN_PERIODS = 0.1, 3.0
LOADS_N = (25.0, 0.5, nao().weight - 0.5)
"""On the left foot: both carry, or one alone."""
LEARN = 12
"""Messages after which the period is known."""
GOES_ON = 5
LATE_S, LATE_PERIODS = 0.05, 2.0
"""A robot that was silent for longer, of itself, may have been told stale, and rightly."""


class Listener:
    """Messages of one topic with when they came."""

    def __init__(self, world: World, kind: type[Any], topic: str, profile: Any = qos.LIVE) -> None:
        self.heard: list[tuple[float, Any]] = []
        world.node.create_subscription(
            kind, topic, lambda message: self.heard.append((time.monotonic(), message)), profile
        )

    def after(self, moment: float) -> int:
        """Messages after a moment."""
        return sum(at > moment for at, _ in self.heard)

    def of_after(self, stamp_ns: int) -> int:
        """Messages of what was sampled after a moment of the robot's [ns], or told again."""
        stamps = [time_from_ros(message.header.stamp) for _, message in self.heard]
        return sum(one > stamp_ns for one in stamps) + len(stamps) - len(set(stamps))


@dataclass(frozen=True)
class Try:
    """What came of one.

    Attributes:
        wrong: what did not hold, beside the time.
        what: stayed away.
        period_s: with which it had come [s].
        took: until the state said so [s].
        needed: by a reading until `shoe/left/grf`, at the worst [s].
    """

    wrong: tuple[str, ...]
    what: str
    period_s: float
    took: float
    needed: float

    @property
    def allowed(self) -> float:
        """Longest time until the state says so [s]."""
        return max(WITHIN_S, WITHIN_PERIODS * self.period_s)

    @property
    def told(self) -> str:
        """In words."""
        wrong = "".join(f"; {one}" for one in self.wrong)
        return (
            f"{1e3 * self.took:.0f} of {1e3 * self.allowed:.0f} ms until {self.what} that came "
            f"every {1e3 * self.period_s:.0f} ms were told stale (a reading takes "
            f"{1e3 * self.needed:.0f} ms){wrong}"
        )


class Scene:
    """A calibrator in force, and a robot."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = StandingRobot(world, DoubleSupport(0.0, -0.112, 0.0))
        self.robot.apart = True
        world.start("calibrator", {"state_dir": world.folder / "state"})
        made = calibration_to_ros(calibration(nao(), nao_shoe()))
        request = SetCalibration.Request(calibration=made)
        assert world.call(SetCalibration, "shoe/set_calibration", request).success
        self.state = Listener(world, ShoeState, "shoe/state", qos.LATCHED)
        self.cop = Listener(world, PointStamped, "shoe/cop")
        self.grf = Listener(world, WrenchStamped, "shoe/grf")
        self.feet = [Listener(world, WrenchStamped, f"shoe/{foot}/grf") for foot in FEET]

    def wait(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self.world.until(lambda: time.monotonic() >= end)

    def told(self, condition: Callable[[Any], bool], since: float) -> float:
        """When a state that meets a condition came."""
        self.world.until(lambda: any(at >= since and condition(m) for at, m in self.state.heard))
        return next(at for at, m in self.state.heard if at >= since and condition(m))

    def try_one(self, rng: np.random.Generator) -> Try:
        """Let something stay away, and come again."""
        what = str(rng.choice(list(AWAY)))
        name, stale, beside = AWAY[what]
        on_left = float(rng.choice(LOADS_N))
        self.robot.forces = (on_left, nao().weight - on_left)
        period_ns = int(rng.choice(PERIODS_NS))
        robot, period_s = self.robot, period_ns / 1e9
        robot.first = int(rng.integers(2))
        robot.publish_every(period_ns)
        told = robot.stamp_ns
        self.world.until(lambda: robot.stamp_ns >= told + LEARN * period_ns)
        self.wait(float(rng.uniform(0.0, 0.1)))
        for one in (self.state, self.cop, self.grf, *self.feet):
            one.heard[:] = one.heard[-1:]
        robot.longest_s = 0.0
        needed = self._needed()
        setattr(robot, f"publishes_{what}", False)
        last = robot.published_at[what]
        late = robot.longest_s > max(LATE_S, LATE_PERIODS * period_s)
        at = self.told(stale, last)
        before = any(_any_stale(one) for when, one in self.state.heard[1:] if when < last)
        # By stamps: what was on its way may come late.
        after = robot.stamp_ns
        self.wait(GOES_ON * period_s + 0.05)
        others = [foot for foot, goes_on in zip(self.feet, beside, strict=True) if goes_on]
        self.world.until(lambda: all(foot.of_after(after) for foot in others))
        went_on = self.cop.of_after(after) or self.grf.of_after(after)
        feet = [foot.of_after(after) > 0 for foot in self.feet]
        wrong = {
            "the sums went on": went_on,
            f"of the feet {feet} went on, not {beside}": feet != beside,
            "something was told stale before": before and not late,
        }
        setattr(robot, f"publishes_{what}", True)
        again = time.monotonic()
        self.world.until(lambda: all(one.after(again) for one in (self.cop, self.grf, *self.feet)))
        self.told(lambda state: not _any_stale(state) and all(f.valid for f in state.feet), again)
        told_wrong = tuple(what for what, so in wrong.items() if so)
        return Try(told_wrong, name, period_s, at - last, needed)

    def _needed(self) -> float:
        """From a reading to `shoe/left/grf`, the worst of some [s]."""
        return max(self._needed_once() for _ in range(GOES_ON))

    def _needed_once(self) -> float:
        last = self.robot.published_at["voltages"]
        self.world.until(lambda: self.robot.published_at["voltages"] > last)
        told = self.robot.published_at["voltages"]
        self.world.until(lambda: self.feet[0].after(told) > 0)
        return next(at for at, _ in self.feet[0].heard if at > told) - told


def _stale_feet(state: ShoeState) -> list[bool]:
    return [foot.stale for foot in state.feet]


def _any_stale(state: ShoeState) -> bool:
    return bool(state.joints_stale or any(_stale_feet(state)))


def tried(first: int, count: int, seed: int, progress: Progress) -> list[Try]:
    """Tries first to first + count - 1."""
    found = []
    with live_world() as world:
        scene = Scene(world)
        # As nodes do, or who listens here would be late by itself.
        freeze_objects()
        try:
            for index in range(first, first + count):
                found.append(scene.try_one(np.random.default_rng([seed, index])))
                progress(len(found))
        finally:
            gc.unfreeze()
    return found


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """How many did not hold, or took too long."""
    found = tried(first, count, seed, progress)
    worst = max(found, key=lambda one: (bool(one.wrong), one.took / one.allowed))
    failed = sum(bool(one.wrong) or one.took > one.allowed for one in found)
    return Result(count, failed, worst.told, worst.took / worst.allowed + bool(worst.wrong))


ROW = Row(
    key="stale-inputs",
    fault="stale joints or voltages",
    holds="what depends on them stops (stale joints: the combined CoP and GRF only) and the "
    "state says stale, within 100 ms or three periods, whichever is longer",
    tries=200,
    step=50,
    run=run,
)
