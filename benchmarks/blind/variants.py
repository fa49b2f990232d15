"""Further looks at the same sets: with something switched off, and with the true effect given."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout, suppress
from functools import cache

from blind.cases import Case
from blind.layout import Round
from blind.submit import Submission, submit
from shoecal_core.cli import main as shoecal
from shoecal_core.recording.session import Session

TRUE = "true effect"
LANDMARKS = "paper's motions only"
WITHOUT: Mapping[str, str] = {
    "without closure": "closure",
    "without tilt": "tilt",
    "without parity": "parity",
    "without unloading": "air",
}
"""What is switched off, by the name of the variant."""
PAPER = frozenset(("landmarks", "reversed"))
"""Motions that the paper has, one way round and the other."""


def run_variants(place: Round, cases: Sequence[Case], jobs: int, ablations: int) -> list[str]:
    """Diagnose sets again in other ways; the variants that the command offers.

    Args:
        place: the round.
        cases: of it, all diagnosed once.
        jobs: processes.
        ablations: of how many sets something is switched off.
    """
    single = [case for case in cases if case.answer.category == "single"]
    todo: list[Submission] = []
    offered = []
    if _offers("--only"):
        offered.append(TRUE)
        todo += [_true(place, case) for case in single if case.certain and case.found]
    chosen = [*single[:ablations], *_clean(cases)[: ablations // 3]]
    if _offers("--without"):
        offered += WITHOUT
        for name, what in WITHOUT.items():
            todo += [_variant(place, case, name, ("--without", what)) for case in chosen]
    offered.append(LANDMARKS)
    for case in chosen:
        session = Session.open(place.recorded(case.answer.number))
        runs = [
            entry.run
            for entry in session.runs
            if entry.hint == "train" and entry.info.motion in PAPER
        ]
        test = [entry.run for entry in session.runs if entry.hint == "test"]
        options = ("--train", _listed(runs), "--test", _listed(test))
        todo.append(_variant(place, case, LANDMARKS, options))
    submit(place, todo, jobs)
    return offered


def _clean(cases: Sequence[Case]) -> list[Case]:
    return [case for case in cases if case.answer.category == "clean"]


def _true(place: Round, case: Case) -> Submission:
    """With the effect that the set has, its size to be found."""
    (truth,) = case.answer.truths
    told = f"{truth.effect}:{','.join(truth.location)}".removesuffix(":")
    return _variant(place, case, TRUE, ("--only", told))


def _variant(place: Round, case: Case, name: str, options: tuple[str, ...]) -> Submission:
    number = case.answer.number
    return Submission(number, place.recorded(number), name.replace(" ", "_"), options)


def _listed(runs: Sequence[int]) -> str:
    return ",".join(map(str, runs))


@cache
def _offers(option: str) -> bool:
    """Whether `shoecal diagnose` has an option."""
    told = io.StringIO()
    with redirect_stdout(told), suppress(SystemExit):
        shoecal(["diagnose", "--help"])
    return option in told.getvalue()
