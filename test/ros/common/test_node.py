from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from rclpy.parameter import Parameter

from shoecal_ros.common.node import ShoecalNode


@pytest.fixture
def node() -> Iterator[ShoecalNode]:
    rclpy.init()
    node = ShoecalNode("sealed")
    yield node
    node.end()
    rclpy.shutdown()


def test_no_parameter_changes_while_a_node_runs(node: ShoecalNode) -> None:
    node.seal()
    before = node.now_ns
    (result,) = node.set_parameters([Parameter("use_sim_time", value=True)])
    assert not result.successful
    assert result.reason.startswith("use_sim_time: parameters stay while a node runs")
    assert not node.get_parameter("use_sim_time").value
    assert node.now_ns >= before, "its clock is still the computer's"


def test_but_those_that_it_changes_itself(node: ShoecalNode) -> None:
    node.mirror = "in_force."
    node.seal()
    node.declare_parameter("in_force.id", "one")
    change = Parameter("in_force.id", value="two")
    assert node.set_parameters([change])[0].successful
    mixed = node.set_parameters_atomically([change, Parameter("use_sim_time", value=True)])
    assert not mixed.successful
