"""What the real nodes say of themselves is what the page says that they say."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

import shoecal_ros
from ros.cures import names_a_cure
from ros.world import World
from shoecal_ros.common import qos
from shoecal_ros.common.health import Level
from shoecal_ros.nodes.simulator import SimulatorSettings

PAGE = Path(__file__).parents[3] / "docs/reference/diagnostics.md"
NODES = ("shoe_driver", "model", "planner", "calibrator", "simulator", "voltage_stream")
STREAM = Path(shoecal_ros.__file__).parent / "voltage_stream.py"
INPUTS = {
    "shoe_driver: device", "model: joints", "planner: joints", "calibrator: joints",
    "calibrator: voltages", "voltage_stream: voltages",
}  # fmt: skip
FIRST = {
    "shoe_driver: device": "port-missing",
    "model: joints": "no-joints",
    "planner: joints": "no-joints",
    "calibrator: joints": "no-joints",
    "calibrator: voltages": "no-voltages",
    "voltage_stream: voltages": "no-voltages",
}
"""What is wrong before there is a robot."""
SIMULATED = "simulator: robot"
COUNTED = {"shoe_driver: device", "calibrator: voltages", "voltage_stream: voltages"}


ERRORS = "the [error's]"
"""Stands for whatever code an error has."""


class Row(NamedTuple):
    """What the page says of one message; subjects of every node have no node."""

    subject: str
    level: Level
    code: str
    message: re.Pattern[str]

    def holds(self, status: DiagnosticStatus) -> bool:
        """Whether a status is this one."""
        return (
            self.subject in (status.name, status.name.partition(": ")[2])
            and status.level == bytes([self.level])
            and (f"`{value(status, 'code')}`" in self.code or ERRORS in self.code)
            and self.message.fullmatch(status.message) is not None
        )


def value(status: DiagnosticStatus, key: str) -> str:
    values: dict[str, str] = {pair.key: pair.value for pair in status.values}
    return values.get(key, "")


@cache
def rows() -> list[Row]:
    found = []
    subject = ""
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|") or len(cells) < 4 or cells[1] not in Level.__members__:
            continue
        name = re.search(r"`(.*)`", cells[0])
        subject = name[1] if name else subject
        message = ".*".join(map(re.escape, cells[3].split("…")))
        found.append(Row(subject, Level[cells[1]], cells[2] or "`ok`", re.compile(message)))
    return found


def test_every_diagnostic_is_on_the_page(world: World) -> None:
    heard = world.receive(DiagnosticArray, "diagnostics", qos.DIAGNOSTICS)
    port = {"port": world.folder / "port"}
    folders = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
    world.start("shoe_driver", {**port, "use_sim_time": True})
    world.start("model", {"use_sim_time": True})
    world.start("planner", {"use_sim_time": True, "steps": True})
    world.start("calibrator", {"use_sim_time": True, **folders})
    world.start("voltage_stream", {"use_sim_time": True}, script=STREAM)
    for node in ("calibrator", "voltage_stream"):
        world.until_reported(node, "voltages", "no voltages yet")
    world.until_reported("shoe_driver", "device", "does not exist")
    for node in ("model", "planner", "calibrator"):
        world.until_reported(node, "joints", "no joint angles yet")
    world.start("simulator", {**port, "offer_reach_support": False})
    for node in ("calibrator", "voltage_stream"):
        world.until_reported(node, "voltages", "voltages come")
    world.until_reported("planner", "joints", "joint angles come")
    world.until_reported("shoe_driver", "device", "reading")
    world.until_reported("simulator", "robot", "stands")

    def well(name: str) -> bool:
        """Whether an input tells a rate, after something was wrong with it."""
        status = world.diagnosis(*name.split(": "))
        return status is not None and float(value(status, "rate_hz") or 0.0) > 10.0

    world.until(lambda: all(well(name) for name in {*INPUTS, "planner: shoes", SIMULATED}))
    reported = {status.name for message in heard.messages for status in message.status}
    subjects = {row.subject for row in rows() if not row.subject.startswith("ADAPTER")}
    everybody = {subject for subject in subjects if ": " not in subject}
    assert reported == (subjects - everybody) | {
        f"{node}: {one}" for node in NODES for one in everybody
    }
    for message in heard.messages:
        for status in message.status:
            assert any(row.holds(status) for row in rows()), status
            assert status.hardware_id == status.name.partition(": ")[0]
            told_badly = status.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR)
            assert names_a_cure(status.message) or not told_badly, status.message
    status = world.diagnosis(*SIMULATED.split(": "))
    assert float(value(status, "age_s")) < 10.0
    factor, rate = (float(value(status, key)) for key in ("real_time_factor", "rate_hz"))
    assert factor == pytest.approx(rate / SimulatorSettings().rate, abs=0.01)
    for name in INPUTS:
        status = world.diagnosis(*name.split(": "))
        assert float(value(status, "age_s")) < 10.0
        assert value(status, "last_error")
        assert value(status, "last_error_age_s").isdigit()
        wrong = [
            value(one, "code")
            for message in heard.messages
            for one in message.status
            if one.name == name and one.level != DiagnosticStatus.OK
        ]
        assert wrong[0] == FIRST[name]
        # A busy machine may be late for more than the first time; one of them was the last.
        assert value(status, "last_error_code") in wrong
        assert value(status, "lost_frames").isdigit() == (name in COUNTED)
