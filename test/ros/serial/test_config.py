from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import FileError
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_ros.serial.channel_map import Converter, Encoding
from shoecal_ros.serial.config import DriverConfig, Mode, load_driver_config
from shoecal_ros.serial.protocol import BinaryDecoder
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

CONFIG = Path(__file__).parents[3] / "config"
TEXT = """
format: 1
port: /dev/ttyACM0
baud: 57600
mode: text
text: {time: ms}
latency_ms: 6.2
alarm_s: 1.5
raw_log: bytes.bin
converter: {volts_per_count: 1.0e-6, bits: 24, encoding: offset_binary}
channels:
  - {index: 1, cell: left/a}
  - {index: 4, cell: left/b, converter: {volts_per_count: 1, bits: 32, encoding: signed}}
"""


def load(tmp_path: Path, text: str) -> DriverConfig:
    path = tmp_path / "driver.yaml"
    path.write_text(text)
    return load_driver_config(path)


def test_the_file_in_the_repository_fits_its_shoe() -> None:
    config = load_driver_config(CONFIG / "nodes/shoe_driver.yaml")
    shoe = load_shoe(CONFIG / "shoes/nao_shoe.yaml")
    assert tuple(channel.cell for channel in config.channels) == shoe.names
    assert config.mode is Mode.BINARY
    assert isinstance(config.decoder(), BinaryDecoder)
    for channel, cell in zip(config.channels, shoe.channels, strict=True):
        volts = channel.converter.volts_per_count
        assert channel.converter.lowest * volts == pytest.approx(cell.lowest)
        assert channel.converter.highest * volts == pytest.approx(cell.highest)


def test_everything_is_read(tmp_path: Path) -> None:
    config = load(tmp_path, TEXT)
    assert (config.port, config.baud, config.mode) == ("/dev/ttyACM0", 57600, Mode.TEXT)
    assert (config.text_time, config.text_columns) == (TextTime.MILLISECONDS, 5)
    assert (config.latency_ns, config.alarm_s) == (6_200_000, 1.5)
    assert config.raw_log == Path("bytes.bin")
    assert isinstance(config.decoder(), TextDecoder)
    assert config.channels[0].converter == Converter(1e-6, 24, Encoding.OFFSET_BINARY)
    assert config.channels[1].converter == Converter(1.0, 32, Encoding.SIGNED)
    assert config.channel_map().unseen == ("left/a", "left/b")


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("format: 1", "format: 2", "format"),
        ("port: /dev/ttyACM0", "", "port"),
        ("baud: 57600", "baud: 0", "baud"),
        ("baud: 57600", "baud: fast", "baud"),
        ("mode: text", "mode: morse", "mode"),
        ("mode: text", "mood: text", "mood"),
        ("{time: ms}", "{time: s}", "text.time"),
        ("{time: ms}", "{time: ms, columns: 4}", "text.columns"),
        ("{time: ms}", "{time: ms, columns: 33}", "text.columns"),
        ("{time: ms}", "{tim: ms}", "text.tim"),
        ("latency_ms: 6.2", "latency_ms: -1", "latency_ms"),
        ("alarm_s: 1.5", "alarm_s: 0", "alarm_s"),
        ("volts_per_count: 1.0e-6", "volts_per_count: 0", "converter.volts_per_count"),
        ("bits: 24", "bits: 33", "converter.bits"),
        ("offset_binary", "gray", "converter.encoding"),
        ("index: 4", "index: 1", "channels[1].index"),
        ("index: 4", "index: 256", "channels[1].index"),
        ("index: 4", "index: -1", "channels[1].index"),
        ("left/b", "left/a", "channels[1].cell"),
        ("bits: 32, ", "", "channels[1].converter.bits"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, old: str, new: str, field: str) -> None:
    assert old in TEXT
    with pytest.raises(FileError) as caught:
        load(tmp_path, TEXT.replace(old, new))
    assert caught.value.field == field
    assert "\n" not in str(caught.value)


def test_no_channels(tmp_path: Path) -> None:
    head, _, _ = TEXT.partition("channels:")
    with pytest.raises(FileError, match="at least one"):
        load(tmp_path, head + "channels: []\n")
