from __future__ import annotations

import shutil
import threading
import time
from pathlib import Path

import pytest
from rclpy.serialization import serialize_message
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import NAO, NAO_SHOE, nao, nao_shoe
from shoecal_core.errors import ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import Session
from shoecal_core.recording.writer import RunWriter
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator.recorder import Recorder
from shoecal_ros.common.conversions import JointSample, header_to_ros, joints_to_ros

SUPPORT = DoubleSupport(0.02, -0.11, 0.2)


class Clock:
    now_ns = 10**9

    def __call__(self) -> int:
        return self.now_ns


def session(folder: Path) -> Session:
    return Session.create(folder / "session", NAO, NAO.with_name("nao.urdf"), NAO_SHOE)


def joints(stamp_ns: int) -> bytes:
    robot = nao()
    sample = JointSample(stamp_ns, robot.joint_names, robot.posture)
    return bytes(serialize_message(joints_to_ros(sample)))


def voltages(stamp_ns: int, sequence: int) -> bytes:
    names = list(nao_shoe().names)
    message = ShoeVoltages(
        header=header_to_ros(stamp_ns, "driver"),
        sequence=sequence,
        cell=names,
        voltage=[0.1] * len(names),
        status=[0] * len(names),
    )
    return bytes(serialize_message(message))


def command() -> bytes:
    return messages.joint_trajectory(0, ["LKneePitch"], [0.5], [[0.1]])


def feed(recorder: Recorder, clock: Clock, samples: int) -> None:
    for _ in range(samples):
        clock.now_ns += 10_000_000
        recorder.take(schemas.JOINT_STATES, [joints(clock.now_ns)])
        recorder.take(schemas.VOLTAGES, [voltages(clock.now_ns, clock.now_ns // 10_000_000)])


def test_a_run_holds_what_came_and_a_little_before(tmp_path: Path) -> None:
    clock = Clock()
    recorder = Recorder(clock, 0.5)
    made = session(tmp_path)
    feed(recorder, clock, 20)  # nobody has asked
    recorder.stand_by()
    recorder.take(schemas.JOINT_TRAJECTORY, [command()])
    feed(recorder, clock, 200)
    started_ns = clock.now_ns
    recorder.start(lambda: made.new_run("landmarks", SUPPORT, hint="train"))
    assert recorder.recording
    feed(recorder, clock, 100)
    recorder.stop()
    feed(recorder, clock, 20)
    recorder.finish()
    (entry,) = made.runs
    run = made.read(entry.run)
    assert entry.hint == "train"
    assert run.info.support == SUPPORT
    assert run.start_ns == pytest.approx(started_ns - 500_000_000, abs=11_000_000)
    assert len(run.joints.time) == len(run.readings.time) == 151
    assert len(run.commanded) == 1, "the command counts however old it is"
    assert recorder.counts == {
        schemas.JOINT_TRAJECTORY: 1, schemas.JOINT_STATES: 151, schemas.VOLTAGES: 151,
    }  # fmt: skip


def test_an_interrupted_run_stays(tmp_path: Path) -> None:
    clock = Clock()
    recorder = Recorder(clock, 0.5)
    made = session(tmp_path)
    recorder.start(lambda: made.new_run("landmarks", SUPPORT))
    feed(recorder, clock, 50)
    recorder.abandon()
    assert not recorder.recording
    recorder.settle()
    assert made.runs == ()
    assert [path.name for path in made.unfinished] == ["run_001.mcap.part"]
    recorder.abandon()  # nothing is left to abandon


def test_a_run_that_cannot_be_written_says_so_once(tmp_path: Path) -> None:
    clock = Clock()
    recorder = Recorder(clock, 0.5)
    made = session(tmp_path)
    writer = made.new_run("landmarks", SUPPORT)
    recorder.start(lambda: writer)
    feed(recorder, clock, 5)
    while recorder.counts.get(schemas.VOLTAGES) != 5:
        time.sleep(0.001)
    writer.abandon()
    feed(recorder, clock, 5)
    while not recorder.problem:
        time.sleep(0.001)
    assert "closed already" in recorder.problem
    recorder.stop()
    with pytest.raises(ShoecalError, match="closed already"):
        recorder.finish()
    recorder.start(lambda: made.new_run("landmarks", SUPPORT))
    assert recorder.problem == ""
    recorder.abandon()
    recorder.settle()


def test_a_run_that_cannot_be_made_says_so(tmp_path: Path) -> None:
    made = session(tmp_path)
    shutil.rmtree(made.folder)
    recorder = Recorder(Clock(), 0.5)
    recorder.start(lambda: made.new_run("landmarks", SUPPORT))
    recorder.settle()
    assert str(made.folder) in recorder.problem
    recorder.stop()
    with pytest.raises(ShoecalError):
        recorder.finish()


def test_a_slow_disk_holds_nothing_up(tmp_path: Path) -> None:
    """To begin a run, to end it whole or interrupted: none waits for the disk."""
    clock, disk = Clock(), threading.Event()
    made = session(tmp_path)

    def make() -> RunWriter:
        disk.wait()
        return made.new_run("landmarks", SUPPORT)

    recorder = Recorder(clock, 0.5)
    for end in (recorder.stop, recorder.abandon):
        disk.clear()
        recorder.start(make)
        feed(recorder, clock, 50)
        end()
        assert not recorder.recording
        assert not recorder.counts
        disk.set()
        recorder.settle()
        assert recorder.counts[schemas.JOINT_STATES] == 50
    assert [entry.run for entry in made.runs] == [1]
    assert len(made.unfinished) == 1


def test_a_clock_that_is_set_back_lets_nothing_pile_up(tmp_path: Path) -> None:
    clock = Clock()
    clock.now_ns = 10**18
    recorder = Recorder(clock, 0.5)
    recorder.stand_by()
    recorder.take(schemas.JOINT_TRAJECTORY, [command()])
    for jump_s in (-3600.0, -2.0, -0.3, 0.3, 3600.0):
        feed(recorder, clock, 100)
        clock.now_ns += round(jump_s * 1e9)
    feed(recorder, clock, 200)
    recorder.start(lambda: session(tmp_path).new_run("landmarks", SUPPORT))
    recorder.stop()
    recorder.finish()
    assert recorder.counts == {
        schemas.JOINT_TRAJECTORY: 1, schemas.JOINT_STATES: 51, schemas.VOLTAGES: 51,
    }  # fmt: skip
