"""A thousand service calls a second while CoP is published.

A real calibrator works on a robot that stands and tells joints and voltages at 100 Hz. Another
program calls `shoe/self_calibrate` (7 of 10 calls), `shoe/get_calibration`, `shoe/rollback` and
`shoe/set_calibration` (with two calibrations in turn), 1,000 times a second. Exactly one
self-calibration must begin; it waits for the double support that this robot never reaches. Two
calibrations are in force, now and before, so one change after the other goes to the disk: such a
call is answered when it is safe there, however long that takes, and the worst is told. Every other
call must be answered within 50 ms (while a change is under way, other changes are refused as busy),
and `/shoe/cop` keep its rate of before within 5 %. A try is a call; where CoP was disturbed, or
nothing changed, every one has failed. Beside it a service that does nothing, of a node that does
nothing, is called now and then: where that takes more than 50 ms, too, it is the machine, and calls
within a quarter of a second are told but have not failed. Simulated: the robot, of which only
messages exist.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from geometry_msgs.msg import PointStamped
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from shoecal_msgs.srv import SetCalibration
from std_msgs.msg import Bool

from reliability.live_robots import PERIOD_NS, WaitedForRobot, start_calibrator
from reliability.live_world import Received, World, live_world
from reliability.row import Progress, Result, Row
from ros.bodies import calibration, nao, nao_shoe
from shoecal_core.workspace import ros_environment
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

CALLER = Path(__file__).with_name("flood_caller.py")
RATE_HZ = 1000.0
ANSWER_S = 0.05
BEFORE_S = 5.0
COP_SHARE = 0.05
NEAR = 250
"""Calls, before and after, that came at the same time."""


@dataclass(frozen=True)
class Flood:
    """What came of a flood of calls.

    Attributes:
        took: (n,) from each call to its answer [s], negative where none came.
        jobs: self-calibrations begun.
        rates: of CoP before and during it [Hz].
        bare: (n,) the same of the service that does nothing, where it was called, too.
        changes: (n,) which calls have put a calibration in force.
        given: CoPs for each frame that the robot sent meanwhile.
    """

    took: NDArray[np.float64]
    jobs: int
    rates: tuple[float, float]
    bare: NDArray[np.float64]
    changes: NDArray[np.bool_]
    given: float

    @property
    def unanswered(self) -> int:
        return int((self.took < 0.0).sum())

    @property
    def cop_share(self) -> float:
        """Rate of CoP over the one before."""
        return self.rates[1] / self.rates[0]

    @property
    def failed(self) -> int:
        """Calls that were not answered in time; all where jobs, changes or CoP are not as due."""
        if self.jobs != 1 or not self.changes.any() or abs(self.cop_share - 1.0) > COP_SHARE:
            return len(self.took)
        return self.unanswered + int((self.late & ~self.held_up).sum())

    @property
    def late(self) -> NDArray[np.bool_]:
        """(n,) Which calls were not answered in time; the disk's does not count."""
        return (self.took > ANSWER_S) & ~self.changes

    @property
    def held_up(self) -> NDArray[np.bool_]:
        """(n,) Which calls came when the machine held up even the service that does nothing."""
        near = np.convolve(self.bare > ANSWER_S, np.ones(2 * NEAR + 1), mode="full")
        return near[NEAR : NEAR + len(self.bare)] > 0.5

    @property
    def told(self) -> str:
        """The worst, in words."""
        median, most, worst = 1e3 * np.quantile(self.took[~self.changes], [0.5, 0.99, 1.0])
        saved = 1e3 * self.took[self.changes].max(initial=0.0)
        return (
            f"{worst:.0f} ms to the answer (median {median:.1f}, 99 % {most:.1f}; a service that "
            f"does nothing: {1e3 * self.bare.max():.0f}; {self.late.sum()} above 50 ms, "
            f"{(self.late & ~self.held_up).sum()} of them when it was not), "
            f"{self.unanswered} unanswered, {self.jobs} job, {self.changes.sum()} changes of the "
            f"calibration (at most {saved:.0f} ms), "
            f"CoP at {100.0 * self.cop_share:.1f} % of its rate"
        )


def flood(count: int) -> Flood:
    """Call `count` times."""
    with live_world() as world:
        robot = WaitedForRobot(world)
        start_calibrator(world)
        requests = [_request(identity) for identity in ("one", "two")]
        for request in requests:
            assert world.call(SetCalibration, "shoe/set_calibration", request).success
        files = [world.folder / f"request_{number}" for number in range(len(requests))]
        for file, request in zip(files, requests, strict=True):
            file.write_bytes(serialize_message(request))
        cop = world.receive(PointStamped, "shoe/cop", qos.LIVE)
        world.until(lambda: len(cop) > 10)
        begin = time.monotonic()
        before, _ = _watched(world, robot, cop, lambda: time.monotonic() - begin >= BEFORE_S)
        out = world.folder / "flood.json"
        with _caller("--serve") as bare, out.open("wb") as log_to:
            with _caller(str(count), str(RATE_HZ), *map(str, files), stdout=log_to) as caller:
                during, given = _watched(world, robot, cop, lambda: caller.poll() is not None)
            bare.kill()
        robot.armed.publish(Bool(data=False))
        world.until_reported("calibrator", "calibration", "not armed")
        told = json.loads(out.read_text())
    changes = np.zeros(count, dtype=bool)
    changes[told["changes"]] = True
    took, bare_took = np.array(told["took"]), np.array(told["bare"])
    return Flood(took, told["accepted"], (before, during), bare_took, changes, given)


def _request(identity: str) -> SetCalibration.Request:
    return SetCalibration.Request(
        calibration=calibration_to_ros(calibration(nao(), nao_shoe(), identity))
    )


def _watched(
    world: World, robot: WaitedForRobot, cop: Received, over: Callable[[], bool]
) -> tuple[float, float]:
    """Rate of CoP until something is over [Hz], and CoPs for each frame sent."""
    heard, begin_ns, begin = len(cop), robot.stamp_ns, time.monotonic()
    world.until(over, timeout_s=600.0)
    heard, frames = len(cop) - heard, (robot.stamp_ns - begin_ns) / PERIOD_NS
    return heard / (time.monotonic() - begin), heard / max(frames, 1.0)


def _caller(*arguments: str, stdout: IO[bytes] | None = None) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, str(CALLER), *arguments], env=ros_environment(), stdout=stdout
    )


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """The calls of one flood; none of them is drawn."""
    del first, seed
    found = flood(count)
    progress(count)
    return Result(count, found.failed, found.told, float(found.took.max()))


ROW = Row(
    key="service-flood",
    fault="1,000 service calls a second for 60 s while CoP is published",
    holds="one job and one change of the calibration at a time, the others answered within 50 ms, "
    "CoP rate within 5 %",
    tries=60_000,
    step=60_000,
    run=run,
)
