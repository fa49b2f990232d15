"""What the real nodes say of themselves is what the page says that they say."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from ros.world import World
from shoecal_ros.common import qos
from shoecal_ros.common.health import Level

PAGE = Path(__file__).parents[3] / "docs/diagnostics.md"
NODES = ("shoe_driver", "model", "planner", "calibrator", "simulator")
INPUTS = {
    "shoe_driver: device", "model: joints", "planner: joints", "calibrator: joints",
    "calibrator: voltages",
}  # fmt: skip
COUNTED = {"shoe_driver: device", "calibrator: voltages"}


@cache
def rows() -> list[tuple[str, Level, re.Pattern[str]]]:
    """Subject, level and message of every row; subjects of every node have no node."""
    found = []
    subject = ""
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if not line.startswith("|") or len(cells) < 3 or cells[1] not in Level.__members__:
            continue
        name = re.search(r"`(.*)`", cells[0])
        subject = name[1] if name else subject
        message = ".*".join(map(re.escape, cells[2].split("…")))
        found.append((subject, Level[cells[1]], re.compile(message)))
    return found


def documented(status: DiagnosticStatus) -> bool:
    level = Level(int.from_bytes(status.level, "little"))
    return any(
        subject in (status.name, status.name.partition(": ")[2])
        and level is known
        and message.fullmatch(status.message)
        for subject, known, message in rows()
    )


def test_every_diagnostic_is_on_the_page(world: World) -> None:
    heard = world.hear(DiagnosticArray, "diagnostics", qos.DIAGNOSTICS)
    port = {"port": world.folder / "port"}
    folders = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
    world.start("shoe_driver", {**port, "use_sim_time": True})
    world.start("model", {"use_sim_time": True})
    world.start("planner", {"use_sim_time": True, "steps": True})
    world.start("calibrator", {"use_sim_time": True, **folders})
    world.until_told("calibrator", "voltages", "no voltages yet")
    world.until_told("shoe_driver", "device", "does not exist")
    world.until_told("model", "joints", "no joint angles yet")
    world.start("simulator", {**port, "offer_reach_support": False})
    world.until_told("calibrator", "voltages", "voltages come")
    world.until_told("planner", "joints", "joint angles come")
    world.until_told("shoe_driver", "device", "reading")
    world.until_told("simulator", "robot", "stands")

    def value(status: DiagnosticStatus, key: str) -> str:
        values: dict[str, str] = {pair.key: pair.value for pair in status.values}
        return values.get(key, "")

    def well(name: str) -> bool:
        """Whether an input tells a rate, after something was wrong with it."""
        status = world.diagnosis(*name.split(": "))
        return status is not None and float(value(status, "rate_hz") or 0.0) > 10.0

    world.until(lambda: all(well(name) for name in {*INPUTS, "planner: shoes"}))
    told = {status.name for message in heard.messages for status in message.status}
    subjects = {subject for subject, _, _ in rows()}
    everybody = {subject for subject in subjects if ": " not in subject}
    assert told == (subjects - everybody) | {
        f"{node}: {one}" for node in NODES for one in everybody
    }
    for message in heard.messages:
        for status in message.status:
            assert documented(status), f"{status.name} ({status.level!r}): {status.message}"
            assert status.hardware_id == status.name.partition(": ")[0]
    for name in INPUTS:
        status = world.diagnosis(*name.split(": "))
        assert float(value(status, "age_s")) < 10.0
        assert value(status, "last_error")
        assert value(status, "last_error_age_s").isdigit()
        assert value(status, "lost_frames").isdigit() == (name in COUNTED)
