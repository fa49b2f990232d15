"""What any peer may send ends no node."""

from __future__ import annotations

from rclpy.serialization import deserialize_message, serialize_message
from shoecal_msgs.msg import ShoeVoltages

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import voltages_from_ros
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.serialised import understood


def read(serialised: bytes) -> VoltageFrame:
    return voltages_from_ros(deserialize_message(serialised, ShoeVoltages))


def test_what_cannot_be_read_is_told_and_the_rest_goes_on() -> None:
    good = serialize_message(ShoeVoltages(cell=["left/a"], voltage=[0.5], status=[0]))
    odd = serialize_message(ShoeVoltages(cell=["left/a"], voltage=[], status=[]))
    problems: list[Problem] = []
    whole, frames = understood([good, odd, b"none", good[:12], good], read, problems.append)
    assert whole == [good, good]
    assert [frame.cells for frame in frames] == [("left/a",)] * 2
    assert "0 voltages and 0 statuses for 1 cells" in str(problems[0])
    unreadable = Code.UNREADABLE_MESSAGE
    assert [problem.code for problem in problems] == ["message", unreadable, unreadable]
    assert not any("\n" in str(problem) for problem in problems)
