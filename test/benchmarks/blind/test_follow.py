"""Which sets are followed by one motion more, and what counts as resolved."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from blind.answers import Answer, Place, Truth
from blind.cases import Case
from blind.follow import PROPOSED, RANDOM, follow
from blind.layout import Round

LATE = Truth("latency", ("left",), {"delay": 0.02}, strength=3.0)
LAG, HEAVY = Place("low_pass", ("left",)), Place("payload", ("base",))


def said(*possible: Place, motion: str | None = None) -> dict[str, Any]:
    proposed = None if motion is None else {"motion": motion, "separates": []}
    told = [{"effect": one.effect, "location": list(one.location)} for one in possible]
    return {"verdict": "ambiguous", "ambiguity_set": told, "next_motion": proposed}


def confused(number: int, *possible: Place, motion: str | None) -> Case:
    told = Answer(
        number, "single", 1, 101, (0, 1), 1.0, imu=True, world={}, truths=(LATE,)
    )  # fmt: skip
    return Case(told, 3.0, (2.0, 40.0), said(*possible, motion=motion))


def diagnosed(place: Round, kind: str, number: int, *possible: Place) -> None:
    """As if the set had been recorded with one run more, and diagnosed."""
    own = Round(place.folder / kind, within=place.sealed)
    own.prepare()
    own.recorded(number).mkdir(parents=True)
    file = own.diagnosis(number)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(said(*possible)))
    own.ledger.parent.mkdir(parents=True, exist_ok=True)
    with own.ledger.open("a") as ledger:
        ledger.write(f"{number} whole 00\n")


def test_what_is_resolved_and_what_cannot_be(tmp_path: Path) -> None:
    place = Round(tmp_path / "round")
    place.prepare()
    both = LATE.place, LAG
    cases = [
        confused(1, *both, motion="faster"),
        confused(2, *both, motion="faster"),
        # Nothing proposed, and a set that lacks the truth.
        confused(3, *both, motion=None),
        confused(4, HEAVY, LAG, motion="faster"),
    ]
    diagnosed(place, PROPOSED, 1, LATE.place)
    diagnosed(place, PROPOSED, 2, LAG)
    diagnosed(place, RANDOM, 1, *both)
    diagnosed(place, RANDOM, 2, *both)
    found = follow(place, cases, 1)
    assert found["resolved_by_proposal"].value == 0.5
    assert found["resolved_by_proposal"].count == 2
    assert found["resolved_by_random"].value == 0.0
    assert found["resolved_above_random"].value == 0.5
    assert found["motion_proposed"].value == 2 / 3
