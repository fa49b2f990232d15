from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from rclpy.parameter import Parameter

from shoecal_core.errors import ShoecalError
from shoecal_ros.common.health import Level
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


def test_lines_bear_the_id_of_the_job_that_is_worked_for(
    node: ShoecalNode, capfd: pytest.CaptureFixture[str]
) -> None:
    with node.working("motion 'hold'", "20261122T034512123"):
        node.log(Level.OK, "planning: at work")
    node.log(Level.OK, "planning: ready")
    said = capfd.readouterr().err.splitlines()
    assert [line.partition("]: ")[2] for line in said] == [
        "[20261122T034512123] motion 'hold' begins",
        "[20261122T034512123] planning: at work",
        "[20261122T034512123] motion 'hold' done",
        "planning: ready",
    ]


def test_how_work_ends_otherwise_is_told_too(
    node: ShoecalNode, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ShoecalError), node.working("motion 'hold'", "1\n2"):
        raise ShoecalError("disarmed; arm again")
    assert node.run_id == ""
    (_, ended) = capfd.readouterr().err.splitlines()
    assert "[WARN]" in ended
    assert ended.endswith("[1 2] motion 'hold' ended: disarmed; arm again")


def test_a_run_id_may_be_anybody_s_text(node: ShoecalNode) -> None:
    with node.working("motion 'hold'", "\x1b[31m../" + 10_000 * "x"):
        assert node.run_id.isprintable()
        assert len(node.run_id) < 200
