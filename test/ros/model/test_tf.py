"""Sole frames on /tf, under the names that are asked for."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest
from sensor_msgs.msg import JointState

from ros.adapters.driver_messages import NoMessagesError, messages_of
from ros.bodies import ROOT, nao, nao_shoe
from ros.world import World
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common.conversions import JointSample, joints_to_ros

LISTENER = Path(__file__).with_name("tf_listener.py")
PERIOD_NS = 50_000_000
ANKLE_TO_SOLE = -0.04519
"""m; height of a NAO's own sole below its ankle."""


@pytest.fixture
def tf(world: World) -> Iterator[World]:
    """A world in which somebody hears /tf."""
    try:
        with messages_of("tf"):
            world.start("tf_listener", script=LISTENER)
            world.until_logged("tf_listener", "listening")
            yield world
            world.kill("tf_listener")
    except NoMessagesError as error:
        pytest.skip(str(error))


def tell_joints(world: World) -> None:
    publisher = world.publisher(JointState, "joint_states")
    stamps = count(10**9, PERIOD_NS)

    def publish() -> None:
        sample = JointSample(next(stamps), nao().joint_names, nao().posture)
        publisher.publish(joints_to_ros(sample))

    world.node.create_timer(PERIOD_NS / 1e9, publish)


def test_names_and_prefix_are_those_asked_for(tf: World) -> None:
    tf.start("model", {"frame_prefix": "left/", "left_sole_frame": "l_shoe"})
    tell_joints(tf)
    states = Kinematics(nao()).states(nao().posture[None])
    height = states.left_translation[0, 2]
    tf.until_logged("tf_listener", f"left/base_link left/l_shoe {height:.3f}")
    tf.until_logged("tf_listener", "left/base_link left/r_sole")


def test_a_link_of_the_urdf_is_not_published_twice(tf: World) -> None:
    """Whoever publishes the robot's links publishes it already."""
    folder = tf.folder / "robots"
    shutil.copytree(ROOT / "config/robots", folder)
    own = f"""<link name="l_sole"/><joint name="l_sole_fixed" type="fixed">
        <parent link="l_ankle_link"/><child link="l_sole"/>
        <origin xyz="0 0 {ANKLE_TO_SOLE - nao_shoe().height}"/></joint></robot>"""
    urdf = folder / "nao.urdf"
    urdf.write_text(urdf.read_text().replace("</robot>", own))
    shoe = ROOT / "config/shoes/nao_shoe.yaml"
    tf.start("model", {"robot_file": folder / "nao.yaml", "shoe_file": shoe})
    tell_joints(tf)
    tf.until_logged("tf_listener", "base_link r_sole")
    assert "l_sole" not in tf.output("tf_listener")


def test_it_can_be_switched_off(tf: World) -> None:
    tf.start("model", {"publish_tf": False})
    tell_joints(tf)
    tf.until_reported("model", "joints", "joint angles come")
    names = [name for name, _ in tf.node.get_publisher_names_and_types_by_node("model", "/")]
    assert "/shoe/model/com" in names
    assert "/tf" not in names
