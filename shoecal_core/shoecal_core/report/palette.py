"""Colours of the reports, each once for light and once for dark surroundings.

A figure is drawn in the light colours; in the page they become CSS variables, so that one
drawing serves both. A colour is named by what it means, and means it on every page. Colours of
data differ in lightness and hue for every common kind of colour vision, and none says alone what
it means: lines differ in their dashes or width too, markers in their shape, bars have names.
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
PASS = Colour("pass", "#17754a", "#4fcf91")
WARN = Colour("warn", "#8d5d00", "#f0b849")
FAIL = Colour("fail", "#b0261e", "#ff8078")
TRUE = Colour("truth", "#0061ae", "#6ab7f7")
CALIBRATED = Colour("calibrated", "#cf4607", "#ff8b4d")
GUESSED = Colour("guess", "#008a70", "#35cfa9")
MODEL = Colour("model", "#48525e", "#c3ccd4")
FOUND = Colour("found", "#007e94", "#46c6dc")
"""Of a diagnosis: what it names, and what stays with that."""
LEFT = Colour("left", "#6a3fb5", "#bda2f7")
RIGHT = Colour("right", "#7c7400", "#cfc440")
PLAIN = Colour("plain", "#76838f", "#8d9aa6")
"""Of what needs no other colour: the body, bars of one kind."""

STEPS = (
    Colour("step1", "#d2659a", "#b25a86"),
    Colour("step2", "#bd5087", "#c26d97"),
    Colour("step3", "#a73e75", "#d182a8"),
    Colour("step4", "#912e64", "#de98ba"),
    Colour("step5", "#792053", "#e9aecb"),
    Colour("step6", "#601442", "#f2c5da"),
    Colour("step7", "#470b30", "#fadcea"),
)
"""Of things in an order, as times and weights: one hue, ever further from the ground."""

SIZES = (
    Colour("size1", "#fbe6ef", "#3d2833"),
    Colour("size2", "#f4c3d8", "#5c3549"),
    Colour("size3", "#e797ba", "#874868"),
    Colour("size4", "#d1689b", "#b25b87"),
    Colour("size5", "#a33c73", "#d98bb0"),
    Colour("size6", "#651745", "#f8d3e4"),
)
"""Of one quantity from small to large, as areas."""

COLOURS = (
    INK, MUTED, RULE, PAPER, CARD, SOLE, PASS, WARN, FAIL,
    TRUE, CALIBRATED, GUESSED, MODEL, FOUND, LEFT, RIGHT, PLAIN, *STEPS, *SIZES,
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


GUESS = Look(GUESSED, 1.1, (4.0, 1.5))
TRUTH = Look(TRUE, 2.2)
MEASURED = Look(CALIBRATED, 1.1)
MODELLED = Look(MODEL, 1.1, (1.2, 1.2))
REFERENCE = Look(MODEL, TRUTH.width, MODELLED.dashes)
"""The model where no truth is known: what all is compared with."""
BEFORE = Look(MODEL, 0.9)
AFTER = Look(FOUND, 1.5)
"""Of residuals: of the model as it is, and with what was found."""
FEET = (Look(LEFT, 1.3), Look(RIGHT, 1.3, (3.5, 1.0)))
"""Left and right, as in all that has a pair."""
ONSET = Look(INK, 1.6, (2.0, 1.0))
"""From here on something is off."""


def variables() -> str:
    """CSS that declares every colour; dark ones on screens only, paper stays light."""
    light, dark = (
        "".join(f"--{colour.name}:{getattr(colour, side)};" for colour in COLOURS)
        for side in ("light", "dark")
    )
    return f":root{{{light}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"
