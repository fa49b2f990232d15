"""Colours of the reports, each once for light and once for dark surroundings.

A figure is drawn in the light colours; in the page they become CSS variables, so that one
drawing serves both. The colours of data differ in lightness and hue for every common kind of
colour vision, and lines differ in their dashes too.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Colour:
    """A role: the name of its CSS variable and its two colours (#rrggbb)."""

    name: str
    light: str
    dark: str


INK = Colour("ink", "#1b2530", "#e7ecf1")
MUTED = Colour("muted", "#5b6875", "#a3b0bc")
RULE = Colour("rule", "#d5dce3", "#3a4652")
PAPER = Colour("paper", "#f3f5f8", "#12181e")
CARD = Colour("card", "#fefefe", "#1a222b")
SOLE = Colour("sole", "#e6ebf0", "#2a343f")
TEAL = Colour("teal", "#008a70", "#35cfa9")
BLUE = Colour("blue", "#0061ae", "#6ab7f7")
RED = Colour("red", "#cf4607", "#ff8b4d")
SLATE = Colour("slate", "#48525e", "#c3ccd4")
PASS = Colour("pass", "#17754a", "#4fcf91")
WARN = Colour("warn", "#8d5d00", "#f0b849")
FAIL = Colour("fail", "#b0261e", "#ff8078")

STEPS = (
    Colour("step1", "#008a71", "#35cfaa"),
    Colour("step2", "#00768f", "#50c3d0"),
    Colour("step3", "#0061af", "#6ab7f8"),
    Colour("step4", "#4a4fa0", "#a3a5f0"),
    Colour("step5", "#8a3a8f", "#d79be6"),
    Colour("step6", "#b03a50", "#f28fa0"),
    Colour("step7", "#cf4608", "#ff8b4e"),
)
"""Of things in an order: runs, weights."""

SIZES = (
    Colour("size1", "#fbe9bb", "#46353c"),
    Colour("size2", "#f8cb7d", "#733f49"),
    Colour("size3", "#f0a24f", "#a34c45"),
    Colour("size4", "#de7038", "#d1713f"),
    Colour("size5", "#b93f3a", "#efa456"),
    Colour("size6", "#7f1e40", "#fbdd9c"),
)
"""Of one quantity from small to large: ever further from the ground, light or dark."""

COLOURS = (
    INK, MUTED, RULE, PAPER, CARD, SOLE, TEAL, BLUE, RED, SLATE, PASS, WARN, FAIL, *STEPS, *SIZES,
)  # fmt: skip


@dataclass(frozen=True)
class Look:
    """How one source of data looks in every figure.

    Attributes:
        colour: of its lines, bars and markers.
        width: of its lines [pt].
        dashes: lengths of dash and gap in widths; empty where solid.
    """

    colour: Colour
    width: float
    dashes: tuple[float, ...] = ()


GUESS = Look(TEAL, 1.1, (4.0, 1.5))
TRUTH = Look(BLUE, 2.2)
MEASURED = Look(RED, 1.1)
MODELLED = Look(SLATE, 1.1, (1.2, 1.2))
BEFORE = Look(RED, 1.1)
AFTER = Look(TEAL, 1.1)
"""Of residuals: without and with an explanation."""


def variables() -> str:
    """CSS that declares every colour; dark ones on screens only, paper stays light."""
    light, dark = (
        "".join(f"--{colour.name}:{getattr(colour, side)};" for colour in COLOURS)
        for side in ("light", "dark")
    )
    return f":root{{{light}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"
