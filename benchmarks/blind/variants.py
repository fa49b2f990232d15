"""Further looks at the same sets: with something switched off, and with the true effect given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from blind.cases import Case
from blind.layout import Round
from blind.submit import Submission, submit
from population import nao
from shoecal_core.planning.motion_sets import TEST, TRAIN
from shoecal_core.recording.session import Session
from shoecal_core.simulation.reality import BASE
from shoecal_core.simulation.sampled_parts import link_names

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


def run_variants(place: Round, cases: Sequence[Case], jobs: int, ablations: int) -> None:
    """Diagnose sets again in other ways.

    Args:
        place: the round.
        cases: of it, all diagnosed once.
        jobs: processes.
        ablations: of how many single sets something is switched off, and of a third as many clean.
    """
    single = [case for case in cases if case.answer.category == "single"]
    todo = [_true(place, case) for case in single if case.certain and case.found]
    for case in (*single[:ablations], *_clean(cases)[: ablations // 3]):
        todo += [_variant(place, case, name, ("--without", what)) for name, what in WITHOUT.items()]
        todo.append(_variant(place, case, LANDMARKS, _of_the_paper(place, case)))
    submit(place, todo, jobs)


def _of_the_paper(place: Round, case: Case) -> tuple[str, ...]:
    """Options that leave out what the paper does not record."""
    session = Session.open(place.recorded(case.answer.number))
    train = [one.run for one in session.runs if one.hint == TRAIN and one.info.motion in PAPER]
    test = [one.run for one in session.runs if one.hint == TEST]
    return "--train", _listed(train), "--test", _listed(test)


def _clean(cases: Sequence[Case]) -> list[Case]:
    return [case for case in cases if case.answer.category == "clean"]


def _true(place: Round, case: Case) -> Submission:
    """With the effect that the set has, its size to be found."""
    (truth,) = case.answer.truths
    root = link_names(nao()[0])[0]
    places = ",".join(root if name == BASE else name for name in truth.location)
    told = f"{truth.effect}:{places}".removesuffix(":")
    return _variant(place, case, TRUE, ("--only", told))


def _variant(place: Round, case: Case, name: str, options: tuple[str, ...]) -> Submission:
    number = case.answer.number
    return Submission(number, place.recorded(number), name.replace(" ", "_"), options)


def _listed(runs: Sequence[int]) -> str:
    return ",".join(map(str, runs))
