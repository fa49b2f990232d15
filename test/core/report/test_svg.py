from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest

from core.report.pages import read_svg
from shoecal_core.report import palette
from shoecal_core.report.svg import canvas, draw_line, line_key, readable


def figure(label: str = "a", points: int = 50) -> str:
    with canvas(120.0) as page:
        axes = page.panel(10.0, 80.0)
        x = np.linspace(0.0, 1.0, points)
        draw_line(axes, x, np.sin(9.0 * x), palette.TRUTH)
        axes.plot((0.1, 0.2), (0.1, 0.2), "o", color=palette.CALIBRATED.light)
        axes.set_title(label)
        page.legend([line_key(palette.GUESS, label)])
        return page.svg(f"A figure of {readable(label)}.")


def test_a_figure_lives_in_a_page() -> None:
    svg = figure()
    root = read_svg(svg)
    assert root.get("viewBox") == "0 0 380 120"
    assert "width" not in root.attrib
    for colour in palette.COLOURS:
        assert colour.light not in svg
    assert "var(--truth)" in svg
    assert "font-family" not in svg
    assert "<style" not in svg
    assert not root.findall(".//metadata")


def test_the_same_figure_is_the_same_bytes() -> None:
    assert figure() == figure()


def test_figures_do_not_share_identifiers() -> None:
    one, other = (
        {element.get("id") for element in read_svg(figure(label)).iter() if element.get("id")}
        for label in "ab"
    )
    assert one
    assert not one & other


def test_long_lines_stay_small() -> None:
    rng = np.random.default_rng(0)
    x, noise = np.linspace(0.0, 1.0, 200_000), rng.normal(size=200_000)
    noise[90_000:90_500] = np.nan
    with canvas(120.0) as page:
        draw_line(page.panel(10.0, 80.0), x, noise, palette.TRUTH)
        svg = page.svg("Noise with a gap.")
    (drawn,) = (one.get("d", "") for one in read_svg(svg).iter("path")
                if "var(--truth)" in one.get("style", ""))  # fmt: skip
    assert drawn.count("M") == 2
    assert len(svg) < 60_000


@pytest.mark.filterwarnings("ignore:Glyph")
@pytest.mark.parametrize("label", ["<b>&\"'", "$\\frac{", "a\x07b\nc", "\ud800", "力", "x" * 500])
def test_any_name_can_be_drawn(label: str) -> None:
    text = "".join(read_svg(figure(readable(label))).itertext())
    assert readable(label) in text
    assert len(readable(label)) <= 28


def test_the_callers_style_is_left_alone() -> None:
    before = dict(mpl.rcParams)
    figure()
    assert dict(mpl.rcParams) == before


def test_the_callers_style_does_not_enter() -> None:
    plain = figure()
    with mpl.rc_context({"axes.facecolor": "black", "lines.linewidth": 9.0, "text.usetex": True}):
        assert figure() == plain
