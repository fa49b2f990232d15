from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.shoe import shoes
from shoecal_core.cli.manual_guide_frames import FrameParser, LineFrame, LineProblem
from shoecal_core.cli.manual_guide_streams import file_stream
from shoecal_core.errors import FileError

SHOE = shoes.shoe("nao_shoe")
NAMES = SHOE.names
VALUES = st.floats(-5.0, 5.0)


def parsed(lines: Iterable[str]) -> list[LineFrame | LineProblem | None]:
    parser = FrameParser(SHOE, Path("lines"))
    return [parser.parse(line) for line in lines]


@given(st.dictionaries(st.sampled_from(NAMES), VALUES, min_size=1), st.integers(0, 2**63 - 1))
def test_json_and_csv_say_the_same(readings: dict[str, float], stamp: int) -> None:
    line = {
        "stamp_ns": stamp, "cells": list(readings), "voltages": list(readings.values()),
        "status": [0] * len(readings),
    }  # fmt: skip
    header = ",".join((*readings, "stamp_ns"))
    row = ",".join(map(repr, (*readings.values(), stamp)))
    (one,), (begin, other) = parsed([json.dumps(line)]), parsed([header, row])
    assert begin is None
    for frame in (one, other):
        assert isinstance(frame, LineFrame)
        assert frame.stamp_ns == stamp
        expected = [readings.get(name, np.nan) for name in NAMES]
        np.testing.assert_array_equal(frame.readings, expected)


def test_what_gave_nothing_is_nan() -> None:
    line = {"cells": NAMES[:4], "voltages": [None, 1.0, 2.0, 3.0], "status": [0, 1, 2, 3]}
    frame, header, row = parsed([json.dumps(line), ",".join(NAMES[:2]), "0.5,"])
    assert isinstance(frame, LineFrame)
    assert isinstance(row, LineFrame)
    assert header is None
    # Saturated is told as it is; no data and a fault are nothing.
    np.testing.assert_array_equal(frame.readings[:4], [np.nan, 1.0, np.nan, np.nan])
    np.testing.assert_array_equal(row.readings[:2], [0.5, np.nan])


def test_numbers_that_no_converter_gives() -> None:
    line = {"cells": NAMES[:2], "voltages": [10**400, -1e200]}
    frame, _, row = parsed([json.dumps(line), ",".join(NAMES[:2]), "inf,nan"])
    for found in (frame, row):
        assert isinstance(found, LineFrame)
        assert np.isnan(found.readings).all()


def test_problems_are_handed_on() -> None:
    assert parsed(['{"problem": "no driver"}', ""]) == [LineProblem("no driver"), None]


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        (["", "{"], "line 2: no JSON"),
        (["{}"], "line 1: needs 'cells' and 'voltages'"),
        (['{"cells": 5, "voltages": []}'], "needs 'cells'"),
        (['{"cells": ["left/nose"], "voltages": [1]}'], "'left/nose' is no cell"),
        (['{"cells": ["left/front_left"], "voltages": ["1"]}'], "is no number"),
        (['{"cells": ["left/front_left"], "voltages": [true]}'], "is no number"),
        (['{"cells": ["left/front_left"], "voltages": []}'], "of equal length"),
        (['{"cells": [["a"]], "voltages": [1]}'], "is no cell"),
        (['{"cells": [], "voltages": [], "stamp_ns": -1}'], "whole nanoseconds"),
        (['{"cells": [], "voltages": [], "stamp_ns": true}'], "whole nanoseconds"),
        (['{"cells": [], "voltages": [], "stamp_ns": 9223372036854775808}'], "is no time"),
        (["nose,ear"], "line 1: 'nose' is no cell"),
        (["left/front_left", "0.1,0.2"], "line 2: 2 values for 1 columns"),
        (["left/front_left", "one"], "line 2: 'one' of left/front_left is no number"),
        (["left/front_left,stamp_ns", "1,x"], "line 2: stamp_ns 'x'"),
    ],
)
def test_lines_that_are_no_readings(lines: list[str], problem: str) -> None:
    with pytest.raises(FileError, match="lines: line") as caught:
        parsed(lines)
    assert problem in str(caught.value)


@given(st.text(max_size=60))
def test_whatever_the_line_there_is_a_frame_or_one_error(text: str) -> None:
    for start in ("", "{", '{"cells": ["left/front_left"], "voltages": ['):
        try:
            parsed([start + text])
        except FileError as error:
            assert len(str(error).splitlines()) == 1  # noqa: PT017 (of either way out)


def test_a_pipe_is_live_and_gives_whole_lines(tmp_path: Path) -> None:
    line = json.dumps({"cells": NAMES[:1], "voltages": [1.0]}).encode()
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR)
    try:
        with file_stream(path, SHOE) as stream:
            assert stream.live
            os.write(writer, line + b"\n" + line[:10])
            stream.receive()
            assert len(list(stream.frames())) == 1
            os.write(writer, line[10:] + b"\n")
            stream.receive()
            assert len(list(stream.frames())) == 1
            assert not stream.ended
    finally:
        os.close(writer)


def test_a_file_waits_and_ends(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text(f"{NAMES[0]}\n1\n2")
    with file_stream(path, SHOE) as stream:
        assert not stream.live
        stream.receive()
        first = next(stream.frames())
        assert isinstance(first, LineFrame)
        assert first.readings[0] == 1.0
        assert not stream.waiting
        stream.receive()
        assert stream.ended
        (second,) = stream.frames()
        assert isinstance(second, LineFrame)
        assert second.readings[0] == 2.0
        assert "has no more readings" in str(stream.complain())
