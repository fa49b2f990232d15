"""A diagnosis on a terminal."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rich.console import Console

from core.report.diagnoses import cause, diagnosis
from shoecal_core.cli.diagnosis_table import print_diagnosis
from shoecal_core.diagnosis.action import action
from shoecal_core.diagnosis.result import Cause, Diagnosis, Verdict


def first_line(found: Diagnosis) -> str:
    console = Console(width=200)
    with console.capture() as printed:
        print_diagnosis(replace(found, action=action(found)), None, console)
    return printed.get().splitlines()[0].replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("one", "line"),
    [
        (
            cause("nonlinearity", "load_cell", ("left/front_left",), 0.96),
            "left/front_left bends with load (96 %): exchange the cell left/front_left",
        ),
        (
            cause("slip", "contact", ("right",), 0.9, run=3),
            "right foot slipped in run 3 (90 %): repeat the run in which right slipped",
        ),
        (
            cause("total_mass", "body", ("all",), 1.0),
            "the robot weighs other than its file says (100 %): weigh the robot",
        ),
    ],
)
def test_the_first_line_names_place_effect_probability_and_cure(one: Cause, line: str) -> None:
    assert first_line(replace(diagnosis(), causes=(one,), next_motion=None)).startswith(line)


def test_without_a_cause_the_first_line_says_what_to_do() -> None:
    found = replace(diagnosis(), verdict="no_gap", causes=(), next_motion=None)
    assert (
        first_line(found)
        == "nothing: CoP and GRF agree with the model as well as on any robot that works"
    )


@pytest.mark.parametrize(
    ("verdict", "title"), [("explained", "What explains it"), ("no_gap", "What was asked for")]
)
def test_what_was_only_asked_for_explains_nothing(verdict: Verdict, title: str) -> None:
    found = replace(diagnosis(), verdict=verdict, next_motion=None)
    assert found.causes
    console = Console(width=200)
    with console.capture() as printed:
        print_diagnosis(found, None, console)
    assert title in printed.get()


def test_what_could_not_be_seen_is_counted_not_spelt_out() -> None:
    unseen = ("floor_tilt", "payload (24 of 25 places: all but Head_link)")
    console = Console(width=200)
    with console.capture() as printed:
        print_diagnosis(replace(diagnosis(), cannot_detect=unseen), None, console)
    assert "could not be seen here (2): floor_tilt; payload (24 of 25 places)\n" in printed.get()
