"""The driver's configuration file, config/nodes/shoe_driver.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from shoecal_core.files import Fields, read_yaml
from shoecal_ros.serial.channel_map import MAX_BITS, ChannelMap, Converter, DeviceChannel, Encoding
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.frame import MAX_CHANNELS
from shoecal_ros.serial.line_form import VALUE, LineForm
from shoecal_ros.serial.protocol import BinaryDecoder
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

FORMAT = 1


class Mode(Enum):
    """What the device sends."""

    BINARY = "binary"
    TEXT = "text"


@dataclass(frozen=True)
class DriverConfig:
    """Everything the driver needs to know of one device.

    Attributes:
        port: serial port; a name under /dev/serial/by-id stays the same after unplugging.
        baud: bits per second.
        mode: binary protocol or text lines.
        text_time, text_columns: of the text lines; columns without the time.
        text_form: of lines with words next to their numbers; None: numbers alone.
        latency_ns: least time from sampling to receipt [ns], taken off every stamp.
        alarm_s: so long without a byte, or without a good frame, is a problem [s].
        raw_log: file that takes every byte received, None for no log.
        channels: the device's channels and their cells.
    """

    port: str
    baud: int
    mode: Mode
    text_time: TextTime
    text_columns: int
    latency_ns: int
    alarm_s: float
    raw_log: Path | None
    channels: tuple[DeviceChannel, ...]
    text_form: LineForm | None = None

    def decoder(self) -> Decoder:
        """A new decoder for what the device sends."""
        if self.mode is Mode.TEXT:
            return TextDecoder(self.text_time, self.text_columns, self.text_form)
        return BinaryDecoder()

    def channel_map(self) -> ChannelMap:
        """A new map for these channels."""
        return ChannelMap(self.channels)


def load_driver_config(path: Path) -> DriverConfig:
    """Read the driver's configuration.

    Raises:
        FileError: for anything missing, mistyped or impossible.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(
        "format", "port", "baud", "mode", "text", "latency_ms", "alarm_s", "raw_log",
        "converter", "channels",
    )  # fmt: skip
    mode = Mode(fields.choice("mode", {mode.value: mode for mode in Mode}))
    channels = _channels(fields, _converter(fields.mapping("converter")))
    time, columns = TextTime.NONE, 1 + max(channel.index for channel in channels)
    form = None
    if "text" in fields:
        text = fields.mapping("text")
        text.only("time", "columns", "line")
        time = TextTime(text.choice("time", {time.value: time for time in TextTime}))
        columns = text.integer("columns", columns, minimum=columns)
        form = _form(text, columns + (time is not TextTime.NONE)) if "line" in text else None
    if mode is Mode.TEXT and columns > MAX_CHANNELS:
        raise fields.error("text.columns", f"{columns} columns; at most {MAX_CHANNELS} can be read")
    raw_log = fields.text("raw_log", "")
    return DriverConfig(
        port=fields.text("port"),
        baud=fields.integer("baud", minimum=1),
        mode=mode,
        text_time=time,
        text_columns=columns,
        text_form=form,
        latency_ns=round(fields.number("latency_ms", 0.0, minimum=0.0, maximum=1000.0) * 1e6),
        alarm_s=fields.number("alarm_s", above=0.0),
        raw_log=Path(raw_log) if raw_log else None,
        channels=channels,
    )


def _form(fields: Fields, count: int) -> LineForm:
    """The form of a line that holds so many numbers, the time among them."""
    try:
        form = LineForm.of(fields.text("line"))
    except ValueError as error:
        raise fields.error("line", str(error)) from error
    if form.count != count:
        raise fields.error(
            "line", f"has {form.count} {VALUE}; the channels, and the time, need {count}"
        )
    return form


def _converter(fields: Fields) -> Converter:
    fields.only("volts_per_count", "bits", "encoding")
    bits = fields.integer("bits", minimum=1)
    if bits > MAX_BITS:
        raise fields.error("bits", f"must be at most {MAX_BITS}, got {bits}")
    encodings = {encoding.value: encoding for encoding in Encoding}
    return Converter(
        volts_per_count=fields.number("volts_per_count", above=0.0),
        bits=bits,
        encoding=encodings[fields.choice("encoding", encodings)],
    )


def _channels(fields: Fields, converter: Converter) -> tuple[DeviceChannel, ...]:
    channels: dict[int, DeviceChannel] = {}
    cells: set[str] = set()
    for entry in fields.items("channels"):
        entry.only("index", "cell", "converter")
        index = entry.integer("index", minimum=0)
        cell = entry.text("cell")
        if index > 255:
            raise entry.error("index", f"must be at most 255, got {index}")
        if index in channels:
            raise entry.error("index", f"{index} appears twice; a channel belongs to one cell")
        if cell in cells:
            raise entry.error("cell", f"'{cell}' appears twice; a cell has one channel")
        own = _converter(entry.mapping("converter")) if "converter" in entry else converter
        channels[index] = DeviceChannel(index, cell, own)
        cells.add(cell)
    if not channels:
        raise fields.error("channels", "is empty; name at least one cell")
    return tuple(channels.values())
