"""The one motion that the diagnosis proposes: does it resolve what was ambiguous?

Every set whose diagnosis left several explanations, the true one among them, and proposed a motion
is made again with one run more: once with that motion, once with one drawn at random from all that
can be proposed. Both are diagnosed once. A set that lacks the truth counts there ("truth in the
ambiguity set") and not here: no motion leaves what is not in it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from blind.by_hand import BY_HAND
from blind.cases import Case, read_diagnosis
from blind.figures import Figure, rate, statistic
from blind.generate import make_set
from blind.layout import Round
from blind.motions import PlannedMotion, extra, standard_set
from blind.processes import over
from blind.submit import Submission, submit
from population import nao
from shoecal_core.diagnosis.candidates import STANCE_MOTION, STANCES, stance
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.standard import TRAIN, PlannedRun
from shoecal_core.planning.supports.feasible import Feasible

PROPOSED, RANDOM = "proposed", "random"
DRAWN = (*MOTION_KINDS, *STANCES, *BY_HAND)
"""What a motion at random is drawn from: all that can be proposed."""


@dataclass(frozen=True)
class _Followed:
    """A set with one run more."""

    case: Case
    kind: str
    motion: str


def follow(place: Round, cases: Sequence[Case], jobs: int) -> dict[str, Figure]:
    """Make and diagnose what is missing of them, and score."""
    confused = _open(cases)
    wanted = [
        _Followed(case, kind, _motion(case, kind))
        for case in confused
        if _proposes(case)
        for kind in (PROPOSED, RANDOM)
    ]
    there = list(over(partial(_make, place), wanted, jobs))
    made = [one for one, can in zip(wanted, there, strict=True) if can]
    for kind in (PROPOSED, RANDOM):
        own = _folder(place, kind)
        submit(
            own,
            [
                Submission(one.case.answer.number, own.recorded(one.case.answer.number))
                for one in made
                if one.kind == kind
            ],
            jobs,
        )
    resolved = {
        kind: [_resolved(place, one) for one in wanted if one.kind == kind]
        for kind in (PROPOSED, RANDOM)
    }
    return {
        "resolved_by_proposal": rate(
            "ambiguity resolved by the one motion proposed", resolved[PROPOSED], low=0.80
        ),
        "resolved_by_random": rate("the same by a random one", resolved[RANDOM]),
        "resolved_above_random": _above(resolved[PROPOSED], resolved[RANDOM]),
        "motion_proposed": rate(
            "ambiguous sets for which a motion is proposed", [_proposes(case) for case in confused]
        ),
    }


def _open(cases: Sequence[Case]) -> list[Case]:
    """Sets with several explanations left, one of them the true one."""
    return [
        case
        for case in cases
        if len(case.places) > 1
        and case.answer.category in {"single", "inseparable"}
        and case.true_places[0] in case.places
    ]


def _proposes(case: Case) -> bool:
    """Whether the diagnosis knows a motion that would help."""
    return case.said is not None and case.said["next_motion"] is not None


def _motion(case: Case, kind: str) -> str:
    assert case.said is not None
    if kind == PROPOSED:
        return str(case.said["next_motion"]["motion"])
    return str(np.random.default_rng([case.answer.seed, 30]).choice(DRAWN))


def _folder(place: Round, kind: str) -> Round:
    """A round of its own, its sealed part inside the sealed one."""
    return Round(place.folder / kind, within=place.sealed)


def _make(place: Round, one: _Followed) -> bool:
    """Record a set anew with one run more; whether that is possible in the simulation."""
    own = _folder(place, one.kind)
    own.prepare()
    if own.recorded(one.case.answer.number).is_dir():
        return True
    try:
        make_set(own, one.case.answer, [_planned(one)])
    except ShoecalError as error:
        print(f"{own.recorded(one.case.answer.number).name}, {one.motion}: {error}", flush=True)
        return False
    return True


def _planned(one: _Followed) -> PlannedMotion:
    """Where and how the nodes run it: in the session's first double support to train in."""
    answer, name = one.case.answer, one.motion
    runs = [standard_set(answer.motions)[index].run for index in answer.order]
    support = next(run.support for run in runs if run.hint == TRAIN)
    motion = name
    if name in STANCES:
        so_far = [run.support for run in runs]
        support = stance(name, Feasible(nao()[0], PlannerSettings()), so_far)
        motion = STANCE_MOTION
    before = BY_HAND.get(name)
    if before is not None:
        motion = before.motion
    planned = extra(answer.motions, PlannedRun(support, motion, TRAIN)).paced(answer.pace)
    return PlannedMotion(PlannedRun(support, name, TRAIN), planned.trajectory, before)


def _resolved(place: Round, one: _Followed) -> bool:
    """Whether one explanation is left, and it is the true one."""
    file = _folder(place, one.kind).diagnosis(one.case.answer.number)
    if not file.is_file():
        return False
    after = dataclasses.replace(one.case, said=read_diagnosis(file.read_text()))
    return len(after.places) == 1 and after.places[0] in after.true_places


def _above(proposed: Sequence[bool], random: Sequence[bool]) -> Figure:
    """By how much the proposed motion resolves more, set by set."""
    rows = [[float(one) - float(other)] for one, other in zip(proposed, random, strict=True)]
    says = "the proposed one above a random one"
    return statistic(says, rows, lambda values: float(np.mean(values)), low=0.25)
