from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, Temperature
from shoecal_msgs.action import ReachSupport
from shoecal_msgs.msg import DoubleSupport, ShoeVoltages
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import ODD, ODD_SHOE, nao, nao_shoe
from ros.world import Goal, World
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import time_from_ros, trajectory_to_ros
from shoecal_ros.common.health import Level
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.simulator.device_file import write_device

NEAR = DoubleSupport(dx=0.02, dy=-0.11, dtheta=0.1)


def start(world: World, **parameters: object) -> Path:
    port = world.folder / "port"
    world.start("simulator", {"port": port, "speed": 4.0, **parameters})
    return port


def reach(world: World) -> Goal:
    return world.goal(ReachSupport, "robot/reach_support", ReachSupport.Goal(support=NEAR))


def test_joints_readings_clock_and_truth_are_of_one_time(world: World, tmp_path: Path) -> None:
    truth_file = tmp_path / "truth.mcap"
    port = start(world, truth_file=truth_file)
    world.start("shoe_driver", {"port": port, "use_sim_time": True})
    joints = world.receive(JointState, "joint_states")
    voltages = world.receive(ShoeVoltages, "shoe/voltages")
    clock = world.receive(Clock, "/clock", qos.CLOCK)
    world.until(lambda: len(joints) > 300 and len(voltages) > 300 and len(clock))
    assert tuple(joints.last.name) == nao().joint_names
    assert tuple(voltages.last.cell) == nao_shoe().names
    stamps = [time_from_ros(one.header.stamp) for one in joints.messages]
    assert set(np.diff(stamps)) == {10_000_000}, "no sample is lost"
    sent = [time_from_ros(one.header.stamp) for one in voltages.messages]
    assert set(np.diff(sent)) == {10_000_000}, "no frame is lost"
    assert set(sent) & set(stamps)
    world.stop("simulator")
    truth = read_truth(truth_file)
    assert truth.grf[-1] == pytest.approx(nao().weight, rel=0.02)
    assert truth.start_ns % 10_000_000 == 0
    assert truth_file.with_suffix(".yaml").is_file()


def test_a_support_is_reached(world: World) -> None:
    start(world)
    # A fast robot tells more than this client takes in: only what it does now counts.
    joints = world.receive(JointState, "joint_states", qos.NEWEST)
    world.until(lambda: len(joints))
    world.arm("simulator")
    goal = reach(world)
    result = goal.result()
    assert (result.success, result.error_code) == (True, ReachSupport.Result.OK)
    assert goal.feedback
    seen = len(joints)
    world.until(lambda: len(joints) > seen + 1)
    angles = nao().from_measured(joints.last.name, np.array(joints.last.position))
    support = Kinematics(nao()).states(angles[None]).support()
    assert support.dx == pytest.approx(NEAR.dx, abs=0.004)
    assert support.dy == pytest.approx(NEAR.dy, abs=0.004)
    assert support.dtheta == pytest.approx(NEAR.dtheta, abs=0.02)
    stamps = [time_from_ros(one.header.stamp) for one in joints.messages]
    assert np.all(np.diff(stamps) > 0)


def test_it_tells_how_warm_its_motors_are_and_which_way_is_up(world: World) -> None:
    start(world)
    temperatures = world.receive(Temperature, "joint_temperatures")
    imu = world.receive(Imu, "imu")
    world.until(lambda: len(temperatures) >= 2 * (len(nao().joint_names) - 1) and len(imu))
    joints = {one.header.frame_id for one in temperatures.messages}
    assert joints == {*nao().joint_names} - {"RHipYawPitch"}, "one message a motor"
    assert all(24.0 < one.temperature < 60.0 for one in temperatures.messages)
    heard = ImuInput(nao())
    heard.take(imu.messages)
    assert heard.up == pytest.approx([0.0, 0.0, 1.0], abs=0.05)


def test_a_robot_without_sensors_of_tilt_and_heat_tells_neither(
    world: World, tmp_path: Path
) -> None:
    reality = tmp_path / "reality.yaml"
    reality.write_text("format: 1\nimu: {present: false}\nservo: {temperatures_told: false}\n")
    temperatures = world.receive(Temperature, "joint_temperatures")
    imu = world.receive(Imu, "imu")
    joints = world.receive(JointState, "joint_states")
    start(world, reality_file=reality)
    # Temperatures come once a simulated second.
    world.until(lambda: len(joints) > 300)
    assert not imu.messages
    assert not temperatures.messages


def test_it_leaves_supports_to_others_where_told_to(world: World) -> None:
    start(world, offer_reach_support=False)
    world.until_reported("simulator", "robot", "stands")
    client = ActionClient(world.node, ReachSupport, "robot/reach_support")
    assert not client.server_is_ready()


def test_nothing_moves_before_it_is_armed(world: World) -> None:
    start(world)
    asked = ReachSupport.Goal(support=NEAR, run_id="20261122T034512123")
    result = world.goal(ReachSupport, "robot/reach_support", asked).result()
    assert result.error_code == ReachSupport.Result.NOT_ARMED
    assert "shoe/arm" in result.message
    world.until_logged("simulator", "[20261122T034512123] placing the robot ended: not armed")


@pytest.mark.parametrize(
    "support", [DoubleSupport(dx=0.5, dy=-0.1), DoubleSupport(dx=float("nan"))]
)
def test_supports_out_of_reach(world: World, support: DoubleSupport) -> None:
    start(world, needs_arming=False)
    goal = world.goal(ReachSupport, "robot/reach_support", ReachSupport.Goal(support=support))
    result = goal.result()
    assert result.error_code in {ReachSupport.Result.UNREACHABLE, ReachSupport.Result.FAILED}
    assert result.message


def test_trajectories_are_followed_or_refused_by_name(world: World) -> None:
    start(world, needs_arming=False)
    joints = world.receive(JointState, "joint_states")
    command = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    world.until(lambda: len(joints))
    goal = nao().posture[nao().joint("HeadYaw")] + 0.3
    motion = JointTrajectory(("HeadYaw",), np.array([0.5]), np.array([[goal]]))
    command.publish(trajectory_to_ros(motion))
    column = nao().joint_names.index("HeadYaw")
    world.until(lambda: abs(joints.last.position[column] - goal) < 0.02)
    wrong = JointTrajectory(("Tail",), np.array([0.5]), np.array([[0.1]]))
    command.publish(trajectory_to_ros(wrong))
    world.until_reported("simulator", "robot", "no joint named 'Tail'")


def test_another_robot_on_other_shoes(world: World, tmp_path: Path) -> None:
    files = {"robot_file": ODD, "shoe_file": ODD_SHOE}
    port = start(world, **files)
    device = tmp_path / "device.yaml"
    shoe = load_shoe(ODD_SHOE)
    write_device(device, shoe, port, 24)
    world.start("shoe_driver", {"config_file": device, "use_sim_time": True})
    voltages = world.receive(ShoeVoltages, "shoe/voltages")
    world.until(lambda: len(voltages) > 10)
    assert tuple(voltages.last.cell) == shoe.names
    assert set(voltages.last.status) == {0}


def test_trajectories_are_refused_unless_armed(world: World) -> None:
    start(world)
    joints = world.receive(JointState, "joint_states")
    command = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    world.until(lambda: len(joints))
    goal = nao().posture[nao().joint("HeadYaw")] + 0.3
    motion = JointTrajectory(("HeadYaw",), np.array([0.5]), np.array([[goal]]))
    command.publish(trajectory_to_ros(motion))
    world.until_reported("simulator", "robot", "not armed")


def test_disarmed_a_command_to_hold_stops_it_and_never_moves_it(world: World) -> None:
    start(world)
    joints = world.receive(JointState, "joint_states")
    command = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    world.until(lambda: len(joints))
    column = nao().joint_names.index("HeadYaw")

    def tell(way: float, duration: float) -> None:
        motion = JointTrajectory(("HeadYaw",), np.array([duration]), np.array([[where() + way]]))
        command.publish(trajectory_to_ros(motion))

    def where() -> float:
        return float(joints.last.position[column])

    def settle(samples: int = 200) -> None:
        seen = len(joints)
        world.until(lambda: len(joints) > seen + samples)

    armed = world.arm("simulator")
    begin = where()
    tell(1.0, 20.0)
    world.until(lambda: abs(where() - begin) > 0.05)
    armed.publish(Bool(data=False))
    world.until_discovered_by("simulator")
    tell(0.19, 0.01)
    settle()
    rest = where()
    for _ in range(5):
        tell(0.19, 0.01)
        settle()
    assert where() == pytest.approx(rest, abs=0.02)


def test_nothing_moves_when_whoever_armed_is_gone(world: World) -> None:
    start(world)
    publisher = world.arm("simulator")
    goal = ReachSupport.Goal(support=NEAR)
    assert world.goal(ReachSupport, "robot/reach_support", goal).result().success
    world.node.destroy_publisher(publisher)
    world.until(
        lambda: (
            world.goal(ReachSupport, "robot/reach_support", goal).result().error_code
            == ReachSupport.Result.NOT_ARMED
        )
    )


@contextmanager
def hanging_listener() -> Iterator[None]:
    """Keeps all joint angles that come to it, and takes none."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("hanging", context=context)
    node.create_subscription(JointState, "joint_states", lambda _: None, qos.RAW)
    try:
        yield
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


def test_a_listener_that_hangs_is_not_waited_for_for_ever(world: World) -> None:
    """Else the simulator could not be ended either: each message would wait anew."""
    clock = world.receive(Clock, "/clock", qos.CLOCK)
    with hanging_listener():
        world.start("simulator", {"port": world.folder / "port", "rate": 1000.0, "speed": 20.0})
        world.until(lambda: len(clock) > 0)
        begun = clock.last.clock.sec
        # The middleware holds twice 5,000 messages.
        world.until(lambda: clock.last.clock.sec > begun + 20)
        assert world.stop("simulator") == 0


def test_a_listener_that_hangs_is_named_until_it_is_gone(world: World) -> None:
    world.receive(JointState, "joint_states", qos.EITHER)
    with hanging_listener():
        world.start("simulator", {"port": world.folder / "port", "rate": 1000.0, "speed": 20.0})
        reported = world.until_reported("simulator", "listeners", "takes nothing")
        assert reported.level == bytes([Level.WARN])
        assert reported.message.startswith("'/hanging' subscribes to /joint_states"), "nobody else"
        assert {pair.key: pair.value for pair in reported.values}["code"] == Code.LISTENER_HANGS
    world.until_reported("simulator", "listeners", "no subscriber hangs")
