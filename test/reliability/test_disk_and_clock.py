"""Full disks, clocks that are set, files of another robot."""

from __future__ import annotations

import contextlib

import pytest

from reliability import clock_jumps, full_disk, other_robot
from reliability.row import Row
from reliability.small_disk import SmallDisk
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_ros.calibrator.calibration_store import CalibrationStore
from shoecal_ros.serial.clock import DeviceClock


@pytest.mark.parametrize(
    ("row", "count"), [(full_disk.ROW, 25), (clock_jumps.ROW, 9), (other_robot.ROW, 30)]
)
def test_it_holds(row: Row, count: int) -> None:
    found = row.run(0, count, 1, lambda _: None)
    assert (found.tried, found.failed) == (count, 0), found.worst


def test_a_disk_that_nobody_can_mount_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SmallDisk, "__enter__", lambda disk: disk)
    found = full_disk.tries(0, 5, 1)
    assert found.failed == 0, found.worst
    assert "RLIMIT_FSIZE" in found.worst


def test_a_store_that_reports_no_refusal_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    apply = CalibrationStore.apply

    def silent(store: CalibrationStore, calibration: Calibration, now_ns: int) -> None:
        with contextlib.suppress(ShoecalError):
            apply(store, calibration, now_ns)

    monkeypatch.setattr(SmallDisk, "__enter__", lambda disk: disk)
    monkeypatch.setattr(CalibrationStore, "apply", silent)
    found = full_disk.tries(0, 1, 1)
    assert found.worst == "try 0: full before: nothing was refused"


def test_stamps_of_the_receipt_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    def receipts(_: DeviceClock, device_us: list[int], receive_ns: int) -> list[int]:
        return [receive_ns] * len(device_us)

    monkeypatch.setattr(DeviceClock, "stamps", receipts)
    assert clock_jumps.ROW.run(0, 6, 1, lambda _: None).failed == 6
