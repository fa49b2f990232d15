from __future__ import annotations

import itertools
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader

from core.recording import samples
from shoecal_core.errors import FileTakenError
from shoecal_core.recording import schemas
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.recover import RecoveryReport, recover, recovered_path
from shoecal_core.recording.run import Run
from shoecal_core.recording.truth import TruthWriter, read_truth
from shoecal_core.shoe.shoe import Shoe

COUNT = 250
ZSTD = re.escape(struct.pack("<I", 4) + b"zstd")
Rescue = Callable[[bytes], RecoveryReport]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, shoe: Shoe) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "run_001.mcap"
    return samples.write_run(path, samples.make_sample(COUNT), shoe.names).read_bytes()


@pytest.fixture(scope="module")
def rescue(tmp_path_factory: pytest.TempPathFactory) -> Rescue:
    """Recover bytes into a new file."""
    folder = tmp_path_factory.mktemp("rescue")
    numbers = itertools.count()

    def run(content: bytes) -> RecoveryReport:
        path = folder / f"{next(numbers)}.mcap"
        path.write_bytes(content)
        return recover(path, path.with_suffix(".out.mcap"))

    return run


def chunk(content: bytes) -> bytes:
    """A whole chunk of these records."""
    data = zstandard.compress(content)
    body = struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content))
    body += struct.pack("<I4sQ", 4, b"zstd", len(data)) + data
    return struct.pack("<BQ", 6, len(body)) + body


def check_part_of_sample(run: Run) -> None:
    """Every value stands at its own time, though some may be missing."""
    sample = samples.make_sample(COUNT)
    start = (run.start_ns - samples.START_NS) / 1e9
    rows = np.rint((run.joints.time + start) * 1e9 / samples.STEP_NS).astype(int)
    np.testing.assert_array_equal(run.joints.position, sample.angles[rows])
    rows = np.rint((run.readings.time + start) * 1e9 / samples.STEP_NS).astype(int)
    np.testing.assert_array_equal(run.readings.value, sample.volts[rows])
    assert run.info == samples.INFO


@settings(max_examples=60)
@given(share=st.floats(0.0, 1.0))
def test_cut_anywhere(share: float, whole: bytes, rescue: Rescue, shoe: Shoe) -> None:
    length = int(share * len(whole))
    start = whole.index(b"zstd") - 41  # opcode, length, times, size, checksum, name's length
    (first,) = struct.unpack_from("<Q", whole, start + 1)
    if length < start + 9 + first:
        with pytest.raises(RecordingError, match="rescued"):
            rescue(whole[:length])
        return
    report = rescue(whole[:length])
    check_part_of_sample(read_run(report.out, shoe))
    assert report.holes_ns == ()
    rescued = report.messages[schemas.JOINT_STATES]
    assert rescued == COUNT if report.whole_end else rescued > (length / len(whole) - 0.3) * COUNT
    assert ("lost: the end" in str(report)) is not report.whole_end


@settings(max_examples=100)
@given(data=st.data())
def test_one_altered_byte(data: st.DataObject, whole: bytes, rescue: Rescue, shoe: Shoe) -> None:
    altered = bytearray(whole)
    place = data.draw(st.integers(0, len(whole) - 1))
    altered[place] ^= data.draw(st.integers(1, 255))
    try:
        report = rescue(bytes(altered))
    except RecordingError:
        assert place < 1000  # in what the file says of itself
        return
    check_part_of_sample(read_run(report.out, shoe))
    lost = 2 * COUNT - sum(report.messages.values())
    assert lost < COUNT
    if lost:
        assert report.holes_ns or not report.whole_end
    assert len(str(report).splitlines()) == 1 + len(report.holes_ns) + (not report.whole_end)


def test_first_chunk_lost(whole: bytes, rescue: Rescue) -> None:
    altered = bytearray(whole)
    altered[whole.index(b"zstd") + 500] ^= 1
    report = rescue(bytes(altered))
    assert report.messages[schemas.VOLTAGES] > COUNT // 2
    assert len(report.holes_ns) == 1
    assert "damaged: 0.00 s at 0.00 s" in str(report)
    with AnyReader([report.out]) as reader:
        assert reader.message_count == sum(report.messages.values())


def test_a_chunk_without_messages_is_passed_over(whole: bytes, rescue: Rescue) -> None:
    """Channels alone, between two chunks and where one is damaged."""
    schema = struct.pack("<HI4sI0sI0s", 99, 4, b"none", 0, b"", 0, b"")
    empty = chunk(struct.pack("<BQ", 3, len(schema)) + schema)
    first, second = (match.start() - 37 for match in list(re.finditer(ZSTD, whole))[:2])
    usual = rescue(whole)
    found = rescue(whole[:second] + empty + whole[second:])
    assert (found.messages, found.holes_ns) == (usual.messages, usual.holes_ns)
    (hole,) = rescue(whole[:second] + b"damage" + empty + whole[second:]).holes_ns
    assert usual.start_ns < hole[0] < hole[1] < usual.end_ns
    assert rescue(whole[:first] + empty + whole[first:]).messages == usual.messages


def test_a_time_that_no_clock_tells_is_damage(whole: bytes, rescue: Rescue) -> None:
    usual = rescue(whole)
    second = list(re.finditer(ZSTD, whole))[1].start() - 37
    message = struct.pack("<HIQQ", 1, 0, 2**63, 2**63) + bytes(8)
    late = chunk(struct.pack("<BQ", 5, len(message)) + message)
    found = rescue(whole[:second] + late + whole[second:])
    assert found.messages == usual.messages
    assert len(found.holes_ns) == 1


def test_nothing_to_rescue(whole: bytes, rescue: Rescue) -> None:
    start = whole.index(b"zstd")
    with pytest.raises(RecordingError, match="nothing can be rescued"):
        rescue(whole[:start])
    with pytest.raises(RecordingError, match="record 'shoecal' is lost or altered"):
        rescue(whole.replace(b"shoecal", b"shoeca_"))
    for content in (whole.replace(b"landmarks", b"landmarkz"), whole[: start // 2], b""):
        with pytest.raises(RecordingError, match="cannot be rescued"):
            rescue(content)


def test_nothing_is_overwritten(tmp_path: Path, whole: bytes) -> None:
    path, out = tmp_path / "run_001.mcap.part", tmp_path / "run_001.mcap"
    path.write_bytes(whole[:-100])
    out.write_text("mine")
    with pytest.raises(FileTakenError, match="never overwritten"):
        recover(path, out)
    assert out.read_text() == "mine"
    assert sorted(tmp_path.iterdir()) == [out, path]


def test_where_rescued_files_go(tmp_path: Path) -> None:
    part, run = tmp_path / "run_001.mcap.part", tmp_path / "run_001.mcap"
    aside = tmp_path / "run_001.recovered.mcap"
    assert recovered_path(part) == run
    assert recovered_path(run) == aside
    run.touch()
    assert recovered_path(part) == aside


def test_truth_is_rescued_too(tmp_path: Path) -> None:
    path = tmp_path / "run_001.mcap"
    with TruthWriter(path, samples.INFO) as writer:
        for step in range(500):
            stamp = samples.START_NS + step * samples.STEP_NS
            writer.write(stamp, [0.0, step], np.ones((2, 2)), [1.0, 2.0])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    truth = read_truth(recover(cut, tmp_path / "out.mcap").out)
    np.testing.assert_array_equal(truth.cop[:, 1], np.arange(len(truth.time)))
