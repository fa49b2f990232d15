"""Joint angles or voltages stay away.

A real calibrator is in force beside a robot that stands on both feet or on one of them and
publishes joints and voltages, each foot's in frames of their own, either first, with a period that
is drawn (5 to 100 ms). At a drawn moment joints, voltages or those of one foot stay away. From the
last message `/shoe/state` must say so, and not before, within 100 ms or three periods, whichever is
longer; without joint angles or one foot's voltages `/shoe/cop` and `/shoe/grf` must end, whose
point and torques are about one sole for both feet (on one foot, too), and those of a foot whose
voltages come go on; without voltages nothing is published; when all come again, so must everything.
Inputs of a robot that was itself late may be reported stale earlier. Simulated: the robot, of which
only messages exist.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, WrenchStamped
from shoecal_msgs.msg import ShoeState

from reliability.live_robots import SUPPORT, start_calibrator
from reliability.live_world import World, live_tries, wait
from reliability.row import Row
from reliability.tries import BrokenError
from ros.bodies import nao
from ros.standing_robot import StandingRobot
from shoecal_core.shoe.shoe import FEET
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros

PERIODS_NS = tuple(round(1e6 * ms) for ms in (5, 10, 20, 33, 50, 100))
WITHIN_S, WITHIN_PERIODS = 0.1, 3.0
LOADS_N = (25.0, 0.5, nao().weight - 0.5)
"""On the left foot: both carry, or one alone."""
LEARN = 12
"""Messages after which the period is known."""
GOES_ON = 5
LATE_S, LATE_PERIODS = 0.05, 2.0
"""Inputs of a robot that was silent for longer, of itself, may rightly be reported stale."""


@dataclass(frozen=True)
class Away:
    """What stays away.

    Attributes:
        name: of the robot's attribute `publishes_...`.
        stale: joints, left foot and right foot in `/shoe/state`.
        goes_on: whether the left and the right foot's forces are still published.
    """

    name: str
    stale: tuple[bool, bool, bool]
    goes_on: tuple[bool, bool]


AWAY = (
    Away("joints", (True, False, False), (True, True)),
    Away("voltages", (False, True, True), (False, False)),
    Away("left", (False, True, False), (False, True)),
    Away("right", (False, False, True), (True, False)),
)


class Listener:
    """Messages of one topic with the monotonic time [s] at which they came."""

    def __init__(self, world: World, kind: type[Any], topic: str, profile: Any = qos.LIVE) -> None:
        self.heard: list[tuple[float, Any]] = []
        world.node.create_subscription(
            kind, topic, lambda message: self.heard.append((time.monotonic(), message)), profile
        )

    def any_after(self, moment: float) -> bool:
        """Whether a message came after a moment."""
        return any(at > moment for at, _ in self.heard)

    def any_of_after(self, stamp_ns: int) -> bool:
        """Whether a message has a stamp after that one [ns], or one that another has, too."""
        stamps = [time_from_ros(message.header.stamp) for _, message in self.heard]
        return max(stamps, default=0) > stamp_ns or len(set(stamps)) < len(stamps)


class Scene:
    """A calibrator in force, a robot, and what is published."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = StandingRobot(world, SUPPORT)
        self.robot.apart = True
        start_calibrator(world)
        self.state = Listener(world, ShoeState, "shoe/state", qos.LATCHED)
        self.sums = [
            Listener(world, PointStamped, "shoe/cop"),
            Listener(world, WrenchStamped, "shoe/grf"),
        ]
        self.feet = [Listener(world, WrenchStamped, f"shoe/{foot}/grf") for foot in FEET]

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """Let something stay away and come again; share of the longest time that it took."""
        away, period_s = AWAY[number % len(AWAY)], self._stand(rng)
        robot, late_s = self.robot, max(LATE_S, LATE_PERIODS * period_s)
        setattr(robot, f"publishes_{away.name}", False)
        last, was_late = robot.published_at[away.name], robot.longest_s > late_s
        at = self._until_state(lambda state: _stale(state) == away.stale, last)
        early = any(any(_stale(state)) for when, state in self.state.heard[1:] if when < last)
        # By stamps: what was on its way may come late.
        after_ns = robot.stamp_ns
        wait(self.world, GOES_ON * period_s + 0.05)
        others = [foot for foot, goes_on in zip(self.feet, away.goes_on, strict=True) if goes_on]
        self.world.until(lambda: all(foot.any_of_after(after_ns) for foot in others))
        if any(one.any_of_after(after_ns) for one in self.sums):
            raise BrokenError(f"without {away.name} CoP or GRF of both feet went on")
        went_on = tuple(foot.any_of_after(after_ns) for foot in self.feet)
        if went_on != away.goes_on:
            raise BrokenError(f"without {away.name} the feet went on: {went_on}")
        if early and not was_late:
            raise BrokenError(f"{away.name} were reported stale while they came")
        setattr(robot, f"publishes_{away.name}", True)
        again = time.monotonic()
        self.world.until(lambda: all(one.any_after(again) for one in (*self.sums, *self.feet)))
        # Not until valid: by its joints no robot stands on one foot alone as this one does.
        self._until_state(lambda one: not any(_stale(one)), again)
        return (at - last) / max(WITHIN_S, WITHIN_PERIODS * period_s)

    def _stand(self, rng: np.random.Generator) -> float:
        """Stand in a drawn way until its period is known; the period [s]."""
        robot, on_left = self.robot, float(rng.choice(LOADS_N))
        robot.forces = (on_left, nao().weight - on_left)
        robot.first = int(rng.integers(2))
        period_ns = int(rng.choice(PERIODS_NS))
        robot.publish_every(period_ns)
        begin_ns = robot.stamp_ns
        self.world.until(lambda: robot.stamp_ns >= begin_ns + LEARN * period_ns)
        wait(self.world, float(rng.uniform(0.0, 0.1)))
        for one in (self.state, *self.sums, *self.feet):
            one.heard[:] = one.heard[-1:]
        robot.longest_s = 0.0
        wait(self.world, GOES_ON * period_ns / 1e9)
        return period_ns / 1e9

    def _until_state(self, condition: Callable[[ShoeState], bool], since: float) -> float:
        """When a state that meets a condition came."""
        heard = self.state.heard
        self.world.until(lambda: any(at >= since and condition(one) for at, one in heard))
        return next(at for at, one in heard if at >= since and condition(one))


def _stale(state: ShoeState) -> tuple[bool, ...]:
    """Whether joints, left and right foot are stale."""
    return state.joints_stale, *(foot.stale for foot in state.feet)


ROW = Row(
    key="stale-inputs",
    fault="stale joints or voltages",
    holds="what depends on them stops (stale joints: the combined CoP and GRF only) and the "
    "state says stale, within 100 ms or three periods, whichever is longer",
    tries=200,
    step=50,
    run=partial(live_tries, Scene, worst="{:.0%} of the time allowed until stale", most=1.0),
)
