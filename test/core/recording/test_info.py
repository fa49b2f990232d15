from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from core.recording import samples
from shoecal_core.errors import ShoecalError
from shoecal_core.recording import info
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.info import RunInfo
from shoecal_core.robot.double_support import DoubleSupport

PATH = Path("run_001.mcap")


@pytest.mark.parametrize("support", [samples.SUPPORT, None])
def test_metadata_round_trip(support: DoubleSupport | None) -> None:
    written = replace(samples.INFO, support=support)
    assert RunInfo.from_metadata(PATH, written.to_metadata()) == written
    noted = replace(written, notes=("a.csv: the last row is left out", "b"))
    assert RunInfo.from_metadata(PATH, noted.to_metadata()) == noted


@pytest.mark.parametrize(
    ("key", "value"), [("run", "0"), ("run", "one"), ("support", "1 2"), ("support", "1 2 inf")]
)
def test_a_record_that_makes_no_sense_is_refused(key: str, value: str) -> None:
    fields = {**samples.INFO.to_metadata(), key: value}
    del fields["checksum"]
    with pytest.raises(RecordingError, match="is not one of shoecal's"):
        RunInfo.from_metadata(PATH, {**fields, "checksum": info._checksum(fields)})


def test_runs_are_numbered_from_one() -> None:
    with pytest.raises(ShoecalError, match="run 0: runs are numbered from 1"):
        replace(samples.INFO, run=0)
