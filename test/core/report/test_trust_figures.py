"""Bars of sources, loads and samples left out."""

from __future__ import annotations

import numpy as np
import pytest

from core.report.pages import read_svg
from shoecal_core.errors import ShapeError
from shoecal_core.report.figures.left_out import RunSpan, left_out_in_time
from shoecal_core.report.figures.sources import largest_sources
from shoecal_core.report.figures.spans import spans


def test_error_sources_by_name() -> None:
    root = read_svg(largest_sources(["zeros of joints", "x" * 90], [12.3, 0.0], "mm", "error"))
    assert {"zeros of joints", "12 mm", "error (mm)"} <= set(root.itertext())
    assert "zeros of joints 12 mm" in root.attrib["aria-label"]


def test_loads_of_each_channel() -> None:
    ends = np.array([[-2.0, 1.0, -0.2], [20.0, 14.0, 0.3]])
    root = read_svg(spans(["a", "b", "c"], ends, "N", usual=6.7))
    told = list(root.itertext())
    assert {"\N{MINUS SIGN}2 to 20", "1 to 14", "0 to 0", "even share of the weight"} <= set(told)
    assert "even share of the weight" not in list(
        read_svg(spans(["a"], ends[:, :1], "N")).itertext()
    )
    with pytest.raises(ShapeError, match="ends"):
        spans(["a"], ends, "N")


def test_samples_left_out_in_time() -> None:
    runs = [
        RunSpan("run 1", 0.0, 30.0, {"spike": [(1.0, 1.0), (4.0, 4.0)], "jolted": [(2.0, 3.0)]}),
        RunSpan("run 2", 0.0, 28.0, {}),
    ]
    root = read_svg(left_out_in_time(runs))
    assert {"counts", "spike", "jolted", "run 2"} <= set(root.itertext())
    label = root.attrib["aria-label"]
    assert "run 1: spike 2 ×, jolted 1 ×; run 2: nothing" in label
