from __future__ import annotations

import importlib

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from ros.clock import Clock
from shoecal_ros.common.health import Level
from shoecal_ros.common.liveness_monitor import ADAPTERS, LivenessMonitor, end_notice


def reported(name: str, subject: str = "joints") -> DiagnosticArray:
    return DiagnosticArray(status=[DiagnosticStatus(name=f"{name}: {subject}", hardware_id=name)])


def level(call: LivenessMonitor) -> Level:
    return call.condition.level


def test_who_falls_silent_is_named_until_he_is_back() -> None:
    clock = Clock()
    call = LivenessMonitor("calibrator", clock)
    call.take([reported("planner"), reported("model"), reported("calibrator"), reported("camera")])
    assert level(call) is Level.OK
    clock.now += 3.0
    call.take([reported("model")])
    clock.now += 1.0
    assert level(call) is Level.ERROR
    assert call.condition.message.startswith("planner sent no diagnostics for 3.5 s")
    call.take([reported("planner")])
    assert level(call) is Level.OK


def test_who_moves_a_real_robot_is_missed_too() -> None:
    clock = Clock()
    call = LivenessMonitor("planner", clock)
    for name in ADAPTERS:
        importlib.import_module(f"shoecal_ros.nodes.{name}")
    call.take([reported(name, "robot") for name in ADAPTERS])
    clock.now += 4.0
    assert all(name in call.condition.message for name in ADAPTERS)


def test_who_says_that_he_ends_is_not_missed() -> None:
    clock = Clock()
    call = LivenessMonitor("calibrator", clock)
    call.take([reported("planner"), end_notice("planner")])
    clock.now += 10.0
    assert level(call) is Level.OK
