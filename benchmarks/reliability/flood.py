"""A thousand service calls a second while CoP is published.

A real calibrator works on a robot that stands and publishes joints and voltages at 100 Hz. Another
program calls `shoe/self_calibrate` (7 of 10 calls), `shoe/get_calibration`, `shoe/rollback` and
`shoe/set_calibration` (with two calibrations in turn), 1,000 times a second. Exactly one
self-calibration must begin; it waits for the double support that this robot never reaches. Two
calibrations are in force, now and before, so one change after the other goes to the disk: such a
call is answered when it is safe there, however long that takes. Every other call must be answered
within 50 ms (while a change is under way, other changes are refused as busy), and the robot's
frames give as many CoPs as before within 5 %. A try is a call; where CoP was disturbed, or nothing
changed, every one has failed. On a computer that is busy with something else calls are late, too.
Simulated: the robot, of which only messages exist.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PointStamped
from rclpy.serialization import serialize_message
from std_msgs.msg import Bool

from reliability.live_robots import PERIOD_NS, WaitedForRobot, put_in_force, start_calibrator
from reliability.live_world import live_world
from reliability.row import Progress, Result, Row
from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.workspace import ros_environment
from shoecal_ros.common import qos

CALLER = Path(__file__).with_name("flood_caller.py")
RATE_HZ = 1000.0
ANSWER_S = 0.05
BEFORE_S = 5.0
COP_SHARE = 0.05


@dataclass(frozen=True)
class Flood:
    """What came of a flood of calls.

    Attributes:
        took: (n,) from each call to its answer [s], negative where none came.
        changes: (n,) which calls have put a calibration in force.
        jobs: self-calibrations begun.
        cop_share: CoPs for each frame of the robot's over those before.
    """

    took: FloatArray
    changes: BoolArray
    jobs: int
    cop_share: float

    @property
    def failed(self) -> int:
        """Calls that were not answered in time; all where jobs, changes or CoP are not as due."""
        if self.jobs != 1 or not self.changes.any() or abs(self.cop_share - 1.0) > COP_SHARE:
            return len(self.took)
        late = (self.took > ANSWER_S) & ~self.changes
        return int((late | (self.took < 0.0)).sum())

    @property
    def worst(self) -> str:
        """In words."""
        return (
            f"{1e3 * self.took[~self.changes].max():.0f} ms to the answer, {self.jobs} job, "
            f"{self.changes.sum()} changes of the calibration, CoP at "
            f"{100.0 * self.cop_share:.1f} % of its rate"
        )


def flood(count: int) -> Flood:
    """Call `count` times."""
    with live_world() as world:
        robot = WaitedForRobot(world)
        start_calibrator(world)
        files = [world.folder / identity for identity in ("one", "two")]
        for file in files:
            file.write_bytes(serialize_message(put_in_force(world, file.name)))
        cops = world.receive(PointStamped, "shoe/cop", qos.LIVE)
        world.until(lambda: len(cops) > 10)

        def cops_per_frame(over: Callable[[], bool]) -> float:
            """CoPs for each frame of the robot's until something is over."""
            cops_before, begin_ns = len(cops), robot.stamp_ns
            world.until(over, timeout_s=600.0)
            return (len(cops) - cops_before) / ((robot.stamp_ns - begin_ns) / PERIOD_NS)

        end = time.monotonic() + BEFORE_S
        before = cops_per_frame(lambda: time.monotonic() >= end)
        command = [sys.executable, str(CALLER), str(count), str(RATE_HZ), *map(str, files)]
        out = world.folder / "flood.json"
        with (
            out.open("wb") as answers,
            subprocess.Popen(command, env=ros_environment(), stdout=answers) as caller,
        ):
            during = cops_per_frame(lambda: caller.poll() is not None)
        robot.armed.publish(Bool(data=False))
        world.until_reported("calibrator", "calibration", "not armed")
        found = json.loads(out.read_text())
    changes = np.isin(np.arange(count), found["changes"])
    return Flood(np.array(found["took"]), changes, found["jobs"], during / before)


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """The calls of one flood; none of them is drawn."""
    del first, seed
    found = flood(count)
    progress(count)
    return Result(count, found.failed, found.worst, float(found.took.max()))


ROW = Row(
    key="service-flood",
    fault="1,000 service calls a second for 60 s while CoP is published",
    holds="one job and one change of the calibration at a time, the others answered within 50 ms, "
    "CoP rate within 5 %",
    tries=60_000,
    step=60_000,
    run=run,
)
