from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from core.recording import samples
from shoecal_core.errors import FileTakenError, NameNotFoundError, ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.container import read_info
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.recover import recover
from shoecal_core.recording.writer import SYNC_NS, RunWriter
from shoecal_core.shoe.shoe import Shoe


def test_rosbags_reads_a_run(tmp_path: Path, shoe: Shoe) -> None:
    sample = samples.make_sample(20)
    path = samples.write_run(tmp_path / "run_001.mcap", sample, shoe.names)
    found: dict[str, list[object]] = {schemas.JOINT_STATES: [], schemas.VOLTAGES: []}
    with AnyReader([path]) as reader:
        for connection, log_time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            numbers = found[connection.topic]
            assert log_time == sample.stamps[len(numbers)]
            field = "position" if connection.topic == schemas.JOINT_STATES else "voltage"
            numbers.append(getattr(message, field))
        for connection in reader.connections:
            assert reader.typestore.hash_rihs01(connection.msgtype) == schemas.type_hash(
                connection.msgtype
            )
    np.testing.assert_array_equal(found[schemas.JOINT_STATES], sample.angles)
    np.testing.assert_array_equal(found[schemas.VOLTAGES], sample.volts)


def test_mcap_ros2_reads_a_run(tmp_path: Path, shoe: Shoe) -> None:
    sample = samples.make_sample(20)
    path = samples.write_run(tmp_path / "run_001.mcap", sample, shoe.names)
    found: dict[str, list[object]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        (record,) = reader.iter_metadata()
        for schema, channel, _, message in reader.iter_decoded_messages():
            assert schema is not None
            assert schema.encoding == "ros2msg"
            assert channel.message_encoding == "cdr"
            assert channel.metadata["topic_type_hash"] == schemas.type_hash(schema.name)
            assert "keep_last" in channel.metadata["offered_qos_profiles"]
            field = "position" if channel.topic == schemas.JOINT_STATES else "voltage"
            found.setdefault(channel.topic, []).append(getattr(message, field))
    assert record.name == "shoecal"
    assert record.metadata["format_version"] == "1"
    assert record.metadata["support"] == "0.02 -0.1 0.3"
    np.testing.assert_array_equal(found[schemas.JOINT_STATES], sample.angles)
    np.testing.assert_array_equal(found[schemas.VOLTAGES], sample.volts)


def test_info_round_trip(tmp_path: Path, shoe: Shoe) -> None:
    path = samples.write_run(tmp_path / "run_001.mcap", samples.make_sample(1), shoe.names)
    assert read_info(path) == samples.INFO


def test_nothing_is_overwritten(tmp_path: Path, shoe: Shoe) -> None:
    path = samples.write_run(tmp_path / "run_001.mcap", samples.make_sample(1), shoe.names)
    before = path.read_bytes()
    with pytest.raises(FileTakenError, match="never overwritten"):
        RunWriter(path, samples.INFO)
    assert path.read_bytes() == before
    with (
        RunWriter(tmp_path / "run_002.mcap", samples.INFO),
        pytest.raises(FileTakenError, match=r"run_002.mcap.part: cannot be made"),
    ):
        RunWriter(tmp_path / "run_002.mcap", samples.INFO)


def test_an_exception_leaves_an_unfinished_file(tmp_path: Path, shoe: Shoe) -> None:
    path = tmp_path / "run_001.mcap"

    def record_and_fall() -> None:
        with RunWriter(path, samples.INFO) as writer:
            samples.write_sample(writer, samples.make_sample(30), shoe.names)
            raise KeyError("robot fell")

    with pytest.raises(KeyError, match="robot fell"):
        record_and_fall()
    assert not path.exists()
    report = recover(tmp_path / "run_001.mcap.part", path)
    assert report.messages[schemas.VOLTAGES] == 30
    assert report.whole_end


def test_only_known_topics_and_times(tmp_path: Path) -> None:
    data = messages.temperature(1, "", 20.0)
    with RunWriter(tmp_path / "run_001.mcap", samples.INFO) as writer:
        with pytest.raises(NameNotFoundError, match=r"/shoe/voltages"):
            writer.write("/shoe/volts", data, 1)
        with pytest.raises(ShoecalError, match="log time"):
            writer.write(schemas.SHOE_TEMPERATURE, data, -1)
        writer.write(schemas.SHOE_TEMPERATURE, data, 1)
    with pytest.raises(RecordingError, match="closed already"):
        writer.write(schemas.SHOE_TEMPERATURE, data, 2)


# A child process: limits and rights that must not touch the tests themselves.
CHILD = f"""
import os, resource, signal, sys
from pathlib import Path
import numpy as np
sys.path[:0] = {[str(Path(samples.__file__).parents[2])]!r}
from core.recording import samples
from shoecal_core.recording import messages, schemas
from shoecal_core.errors import FileError, error_code
from shoecal_core.recording.writer import RunWriter

def record(writer, count):
    for index in range(count):
        stamp = samples.START_NS + index * samples.STEP_NS
        angles = np.sin(index + np.arange(3))
        joints = messages.joint_state(stamp, samples.JOINTS, angles)
        writer.write(schemas.JOINT_STATES, joints, stamp)
        if index % 50 == 49:
            print(index, flush=True)
"""


def child(script: str, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CHILD + script], stdout=subprocess.PIPE, text=True, cwd=folder
    )


@pytest.mark.parametrize("lines", [2, 9, 40])
def test_kill_loses_less_than_a_second(tmp_path: Path, lines: int) -> None:
    script = "record(RunWriter(Path('run_001.mcap'), samples.INFO), 10**9)"
    path = tmp_path / "run_001.mcap"
    with child(script, tmp_path) as process:
        assert process.stdout is not None
        told = [int(process.stdout.readline()) for _ in range(lines)]
        process.kill()
    assert not path.exists()
    report = recover(tmp_path / "run_001.mcap.part", path)
    assert not report.whole_end
    assert report.holes_ns == ()
    last_told = samples.START_NS + told[-1] * samples.STEP_NS
    assert report.end_ns >= last_told - SYNC_NS
    with AnyReader([path]) as reader:
        for index, (connection, log_time, data) in enumerate(reader.messages()):
            assert log_time == samples.START_NS + index * samples.STEP_NS
            message = reader.deserialize(data, connection.msgtype)
            position = getattr(message, "position", None)
            np.testing.assert_array_equal(position, np.sin(index + np.arange(3)))


def test_full_disk_is_told_again_and_again(tmp_path: Path) -> None:
    script = """
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
writer = RunWriter(Path('run_001.mcap'), samples.INFO)
errors = []
for attempt in (lambda: record(writer, 10**9), lambda: record(writer, 1), writer.close):
    try:
        attempt()
    except FileError as error:
        errors.append(error)
assert len({id(error) for error in errors}) == 1 and len(errors) == 3, errors
print(error_code(type(errors[0])), errors[0])
"""
    with child(script, tmp_path) as process:
        output, _ = process.communicate()
    assert process.returncode == 0
    told = output.splitlines()
    assert told[-1].startswith("disk-full ")
    assert "run_001.mcap.part: cannot be written (File too large)" in told[-1]
    report = recover(tmp_path / "run_001.mcap.part", tmp_path / "out.mcap")
    assert report.end_ns >= samples.START_NS + int(told[-2]) * samples.STEP_NS - 2 * SYNC_NS


def test_full_disk_at_the_end_is_told(tmp_path: Path) -> None:
    script = """
writer = RunWriter(Path('run_001.mcap'), samples.INFO)
record(writer, 10)
size = os.path.getsize('run_001.mcap.part')
resource.setrlimit(resource.RLIMIT_FSIZE, (size + 100, size + 100))
try:
    writer.close()
except FileError as error:
    print(error_code(type(error)), error)
assert not os.path.exists('run_001.mcap') and os.path.exists('run_001.mcap.part')
"""
    with child(script, tmp_path) as process:
        output, _ = process.communicate()
    assert process.returncode == 0
    assert output.splitlines()[-1].startswith("disk-full ")
    assert "cannot be written" in output


def test_read_only_folder(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir(mode=0o555)
    # Rights do not bind the superuser, so the child gives that up.
    script = """
if os.geteuid() == 0:
    os.setuid(65534)
try:
    RunWriter(Path('run_001.mcap'), samples.INFO)
except FileError as error:
    print(error_code(type(error)), error)
"""
    with child(script, folder) as process:
        output, _ = process.communicate()
    assert output.startswith("file-unwritable ")
    assert "run_001.mcap.part: cannot be made (Permission denied)" in output
    assert list(folder.iterdir()) == []
