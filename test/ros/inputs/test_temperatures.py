from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import Temperature

from ros.bodies import nao
from ros.clock import Clock
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.inputs.temperatures import KEEP_S, TemperatureInput


def reported(joint: str, degc: float) -> Temperature:
    return Temperature(header=header_to_ros(0, joint), temperature=degc)


def test_one_message_a_motor() -> None:
    heard = TemperatureInput(nao())
    heard.take(
        [reported("LKneePitch", 40.0), reported("RKneePitch", 50.0), reported("LKneePitch", 41.0)]
    )
    assert heard.degc == {"LKneePitch": 41.0, "RKneePitch": 50.0}


def test_what_is_no_motor_of_the_robot_does_not_count() -> None:
    heard = TemperatureInput(nao())
    heard.take([reported("Battery", 90.0), reported("LKneePitch", float("nan"))])
    assert heard.degc == {}


def test_diagnostics_of_joints() -> None:
    heard = TemperatureInput(nao())
    status = DiagnosticStatus(
        name="driver_joints:LKneePitch",
        hardware_id="LKneePitch",
        values=[KeyValue(key="Stiffness", value="1"), KeyValue(key="Temperature", value="62")],
    )
    other = DiagnosticStatus(
        hardware_id="Battery", values=[KeyValue(key="Temperature", value="80")]
    )
    wrong = DiagnosticStatus(
        hardware_id="RKneePitch", values=[KeyValue(key="Temperature", value="warm")]
    )
    heard.take_diagnostics([DiagnosticArray(status=[status, other, wrong])])
    assert heard.degc == {"LKneePitch": 62.0}


def test_old_temperatures_are_forgotten() -> None:
    clock = Clock()
    heard = TemperatureInput(nao(), clock)
    heard.take([reported("LKneePitch", 40.0)])
    clock.now += KEEP_S - 1.0
    assert heard.degc
    clock.now += 2.0
    assert not heard.degc
    assert heard.ages == {"LKneePitch": KEEP_S + 1.0}
