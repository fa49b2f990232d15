from __future__ import annotations

import math

import pytest

from core.report import diagnoses
from shoecal_core.diagnosis.result import NamedHypothesis, Size, Where
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.report.diagnosis.words import (
    ALIKE,
    MOTIONS,
    hypothesis_text,
    label_text,
    listed,
    motion_text,
    place_text,
    size_text,
    sizes_text,
    state_text,
    where_text,
    why_alike,
)


@pytest.mark.parametrize(
    ("effect", "size", "text"),
    [
        ("latency", Size(0.0123, "s", (0.01, 0.0146)), "12.3 ms (95 %: 10.0 to 14.6)"),
        ("creep", Size(12.0, "s", (9.0, 15.0)), "12.0 s (95 %: 9.0 to 15.0)"),
        ("cell_position", Size(-0.002, "m", (-0.003, -0.001)), "−2.00 mm (95 %: −3.00 to −1.00)"),
        ("joint_offset", Size(math.radians(2), "rad", (0.0, math.radians(3))),
         "2.00° (95 %: 0.00 to 3.00)"),
        ("crosstalk", Size(0.05, "", (0.04, 0.06)), "5.00 % (95 %: 4.00 to 6.00)"),
        ("inertia", Size(0.98, "", (0.9, 1.06)), "0.98 (95 %: 0.90 to 1.06)"),
        ("nonlinearity", Size(-3.1e-8, "1/N^2", (-4e-8, -2e-8)),
         "−3.10·10⁻⁸ 1/N^2 (95 %: −4.00·10⁻⁸ to −2.00·10⁻⁸)"),
        ("payload", Size(0.0, "kg", (0.0, 0.0)), "0 kg (95 %: 0 to 0)"),
        ("payload", Size(math.nan, "kg", (0.0, 1.0)), "– kg (95 %: – to –)"),
    ],
)  # fmt: skip
def test_sizes_in_units_for_a_person(effect: str, size: Size, text: str) -> None:
    assert size_text(effect, size).replace("\N{NO-BREAK SPACE}", " ") == text


def test_places() -> None:
    assert place_text("stuck_cell", ("left/a",)) == "cell left/a"
    assert place_text("swapped_cells", ("left/a", "left/b")) == "cells left/a and left/b"
    assert place_text("crosstalk", ("left/a", "left/b")) == "cell left/a shows left/b"
    assert place_text("latency", ("right",)) == "right foot"
    assert place_text("latency", ("all",)) == "both feet"
    assert place_text("backlash", ("all",)) == "all joints of the legs"
    assert place_text("joint_offset", ("LKnee",)) == "joint LKnee"
    assert place_text("payload", ("torso",)) == "link torso"
    assert place_text("floor_tilt", ()) == ""
    assert place_text("mine", ("tail",)) == "tail"


def test_labels_read_as_hypotheses() -> None:
    one = NamedHypothesis("crosstalk", ("left/a", "left/b"), 0.5)
    other = NamedHypothesis("floor_tilt", (), 0.5)
    assert label_text(one.label) == hypothesis_text(one) == "crosstalk (cell left/a shows left/b)"
    assert label_text(other.label) == "floor tilt"
    assert label_text(f"{one.label} and {other.label}").endswith("left/b) and floor tilt")


def test_where_it_is() -> None:
    place = Where("cop_y", "left", None, "LKnee", 3, "both_feet", 12.34, 0.5)
    assert (
        where_text(place)
        == "CoP sideways at the left foot at joint LKnee in run 3 (both feet) from 12.3 s on"
    )
    assert where_text(Where("new", None, "left/a", None, None, None, None, 0.1)) == (
        "new at cell left/a"
    )


def test_why_it_cannot_be_told_apart() -> None:
    assert "exactly" in why_alike(("crosstalk (left/a, left/b)", "cell_position (left/b)"))
    assert "places" in why_alike(("payload (torso)", "payload (head)"))
    assert why_alike(("stuck_cell (left/a)", "payload (head)")) == ALIKE


def test_every_motion_of_the_menu_has_words() -> None:
    assert set(MOTION_KINDS) <= set(MOTIONS)
    assert motion_text("dance_slowly") == "dance slowly"
    assert "known weight" in motion_text("known_weight")


def test_several_components() -> None:
    slip = diagnoses.cause("slip", "contact", ("left",), 0.9, dx=(0.004, "m"), time=(12.4, "s"))
    assert sizes_text(slip).startswith("dx 4.00")
    assert ", time 12.4" in sizes_text(slip)
    assert state_text(slip) == "left foot slipped"


def test_lists() -> None:
    assert listed([]) == ""
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"], "or") == "a, b or c"
