"""Processes that are killed while they write."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

from reliability import killed_recording, killed_saving, recovered
from reliability.row import Row
from shoecal_core.estimation.calibration import Calibration, save_calibration


@pytest.mark.parametrize(("row", "count"), [(killed_recording.ROW, 20), (killed_saving.ROW, 20)])
def test_nothing_is_lost_that_was_whole(row: Row, count: int) -> None:
    found = row.run(0, count, 1, lambda _: None)
    assert (found.tried, found.failed) == (count, 0), found.worst


def test_a_run_that_is_not_recovered_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recovered, "recover", lambda _run, _out: None)
    found = killed_recording.ROW.run(0, 10, 1, lambda _: None)
    assert found.failed
    assert " s lost" in found.worst


def test_a_file_that_is_cut_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def write_slowly(calibration: Calibration, path: Path) -> None:
        whole = path.with_name("whole.yaml")
        save_calibration(calibration, whole)
        text = whole.read_text()
        with path.open("w") as file:
            for part in (text[:100], text[100:]):
                file.write(part)
                file.flush()
                time.sleep(0.05)

    monkeypatch.setattr(killed_saving, "save_calibration", write_slowly)
    found = killed_saving.ROW.run(0, 20, 1, lambda _: None)
    assert found.failed > 1
    assert "calibration.yaml" in found.worst


def test_a_calibration_of_mixed_content_is_not_whole() -> None:
    one, other = killed_saving.made_from(1), killed_saving.made_from(2)
    both = {each.id: each for each in (one, other)}
    assert killed_saving.name_of(one, both) == "made-1"
    mixed = replace(one, parameters=replace(one.parameters, gain=other.parameters.gain))
    assert killed_saving.name_of(mixed, both) == "made-1 with other content"
    assert killed_saving.name_of(replace(one, id="made-3"), both) == "made-3 with other content"
