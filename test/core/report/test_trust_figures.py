"""Bars of sources, and samples left out."""

from __future__ import annotations

from core.report.pages import read_svg
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.palette import PLAIN
from shoecal_core.report.screening_parts import RunSpan, left_out_in_time


def test_error_sources_by_name() -> None:
    long = NamedBar("x" * 90, "0 mm", 0.0, PLAIN)
    bars = [NamedBar("zeros of joints", "12 mm", 1.0, PLAIN), long]
    root = read_svg(named_bars(bars, "Sources"))
    assert {"zeros of joints", "12 mm"} <= set(root.itertext())
    assert root.attrib["aria-label"].startswith("Sources: zeros of joints 12 mm; x")


def test_samples_left_out_in_time() -> None:
    runs = [
        RunSpan("run 1", 0.0, 30.0, {"spike": [(1.0, 1.0), (4.0, 4.0)], "jolted": [(2.0, 3.0)]}),
        RunSpan("run 2", 0.0, 28.0, {}),
    ]
    root = read_svg(left_out_in_time(runs))
    assert {"counts", "spike", "jolted", "run 2"} <= set(root.itertext())
    label = root.attrib["aria-label"]
    assert "run 1: spike 2 ×, jolted 1 ×; run 2: nothing" in label
