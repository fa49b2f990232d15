"""Lines with words and units beside their numbers, as the usual sketches print them."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import FileError
from shoecal_ros.serial.config import load_driver_config
from shoecal_ros.serial.frame import Frame, FrameFault
from shoecal_ros.serial.line_form import LineForm
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

PRINTED = {
    "Reading: {} lbs calibration_factor: {_}": (
        b"Reading: 12.4 lbs calibration_factor: -7050.00\n", [12.4], b"HX711 scale demo 1.2\n",
    ),
    "{},lbs,": (b"12.34,lbs,\n", [12.34], b"System calibration: factor -7050\n"),
    "reading,{}kg,{_}": (b"reading,0.0kg,-10.00\n", [0.0], b"reading,kg,-10.00\n"),
    "Load_cell output val: {}": (b"Load_cell output val: 123.45\n", [123.45], b"123.45\n"),
    "one reading: {} | average: {_}": (
        b"one reading:\t-3.2\t| average:\t5.1\n", [-3.2], b"one reading: | average: 5.1\n",
    ),
    "{} g {} g": (b"1.5 g nan g\n", [1.5, 0.0], b"1.5 g\n"),
}  # fmt: skip


@pytest.mark.parametrize("form", PRINTED)
def test_lines_are_read_by_their_form_and_no_others(form: str) -> None:
    line, values, other = PRINTED[form]
    decoder = TextDecoder(TextTime.NONE, len(values), LineForm.of(form))
    decoder.feed(b"\n")
    (frame,) = decoder.feed(line)
    assert isinstance(frame, Frame)
    assert list(frame.counts) == values
    (fault,) = decoder.feed(other)
    assert isinstance(fault, FrameFault)
    assert f"not of the form '{form}'" in fault.text


def test_the_first_number_may_be_the_time() -> None:
    decoder = TextDecoder(TextTime.MILLISECONDS, 1, LineForm.of("t={}: {} N"))
    decoder.feed(b"\n")
    (frame,) = decoder.feed(b"t=1500:   -2.5 N\n")
    assert isinstance(frame, Frame)
    assert (frame.device_time_us, list(frame.counts)) == (1_500_000, [-2.5])


def test_without_a_form_words_are_told_with_the_cure() -> None:
    decoder = TextDecoder(TextTime.NONE, 1)
    decoder.feed(b"\n")
    (fault,) = decoder.feed(b"12.34,lbs,\n")
    assert isinstance(fault, FrameFault)
    assert "print numbers alone, or give 'text.line'" in fault.text


@pytest.mark.parametrize("form", ["{} lbs", "a {} b {} c", "{}x{_}"])
def test_long_lines_take_no_long_time(form: str) -> None:
    """Nothing in a form is tried twice."""
    shape = LineForm.of(form)
    for line in ("1" * 1000 + "x", "1e" * 500, " " * 1000 + "1", "a " + "9." * 500):
        shape.numbers(line)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("Reading:", "has no {}"), ("{}{}", "two numbers with nothing between"),
        ("{} {} {}", "has 3 {}; the channels, and the time, need 2"),
    ],
)  # fmt: skip
def test_forms_that_cannot_be_read(line: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / "driver.yaml"
    file.write_text(
        f"format: 1\nport: /dev/x\nbaud: 9600\nmode: text\nalarm_s: 2.0\n"
        f"text: {{time: ms, line: '{line}'}}\n"
        "converter: {volts_per_count: 1.0, bits: 24, encoding: signed}\n"
        "channels: [{index: 0, cell: left/a}]\n"
    )
    with pytest.raises(FileError) as caught:
        load_driver_config(file)
    assert told in str(caught.value)
    file.write_text(file.read_text().replace(f"'{line}'", "'{} ms {} N'"))
    assert load_driver_config(file).text_form is not None
