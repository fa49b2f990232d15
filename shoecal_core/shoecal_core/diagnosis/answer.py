"""What is answered, by how large the gap is, what explains it, and how much of it then goes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.hidden import hidden_cop
from shoecal_core.diagnosis.result import Candidate, Cause, Verdict
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.selection import Found, happened
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import excess, gap, shrink
from shoecal_core.diagnosis.sizes import sizes
from shoecal_core.diagnosis.tempering import shares, temper
from shoecal_core.diagnosis.workspace import Workspace

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Answer:
    """What is said.

    Attributes:
        verdict, causes: as in `Diagnosis`.
        ambiguity: what cannot be told apart from the first cause, itself included.
        ranking: of everything that could stand in its place.
    """

    verdict: Verdict
    causes: tuple[Cause, ...] = ()
    ambiguity: tuple[Candidate, ...] = ()
    ranking: tuple[Candidate, ...] = ()


def answer(
    workspace: Workspace,
    best: Workspace,
    certain: Sequence[Cause],
    found: Found,
    settings: DiagnosisSettings,
) -> Answer:
    """The verdict.

    Args:
        workspace: with nothing added. best: the same, or under the wiring that was found and
            with a stuck cell's readings mended.
        certain: causes that no fit was needed for.
    """
    before, _ = workspace.explained(None)
    size = gap(best, before)
    over_floor = max(size.cop_mae_mm / size.cop_floor_mm, size.grf_mae_n / size.grf_floor_n)
    there = over_floor > settings.gap_from
    nothing_fits: Verdict = "unknown" if over_floor > settings.unknown_from else "no_gap"
    causes = [*certain, *causes_of(best, found, before, settings)]
    ranking = probabilities(found, 0, settings) if found.alternatives else ()
    ambiguity = ambiguity_set(ranking, settings) if ranking else ()
    if certain:
        first = certain[0]
        ambiguity = (Candidate(first.effect, first.location, first.probability),)
        ranking = (*ambiguity, *ranking)
    if not there and not certain and not happened(best, found, settings):
        return Answer("no_gap", ranking=ranking)
    if not causes:
        return Answer(nothing_fits)
    after, _ = best.explained(found.chosen)
    over, left = excess(best, before), excess(best, after)
    # What happened once, in a run that was fitted, is no gap of the others.
    explained = 1.0 - max(left, 0.0) / over if there and over > 0.0 else 1.0
    if explained < settings.unknown_below and not certain:
        return Answer(nothing_fits, ranking=ranking)
    verdict: Verdict = "ambiguous" if len(ambiguity) > 1 else "explained"
    if explained < settings.explained_from:
        verdict = "partly_explained"
    return Answer(verdict, tuple(causes), ambiguity, ranking)


def causes_of(
    workspace: Workspace, found: Found, before: FloatArray, settings: DiagnosisSettings
) -> list[Cause]:
    """All parts of what was chosen, with sizes, shrink and hidden part."""
    if found.chosen is None:
        return []
    return [
        _cause(
            workspace, found.chosen, index, before, probabilities(found, index, settings), settings
        )
        for index in range(len(found.alternatives))
    ]


def probabilities(found: Found, index: int, settings: DiagnosisSettings) -> tuple[Candidate, ...]:
    """Of everything that could stand in a cause's place, nothing and the unknown included.

    What a cause explains beside much stronger ones may be what these have in another form.
    """
    alternatives = found.alternatives[index]
    together = found.chosen.evidence if found.chosen is not None else 0.0
    best = max((one for _, one in alternatives), default=0.0)
    counts = temper(max(best, together), settings)
    each = (1.0 - settings.outside) * shares([*(counts * one for _, one in alternatives), 0.0])
    return tuple(
        Candidate(hypothesis.effect.identifier, hypothesis.place, float(share))
        for (hypothesis, _), share in zip(alternatives, each[:-1], strict=True)
    )


def ambiguity_set(
    ranking: Sequence[Candidate], settings: DiagnosisSettings
) -> tuple[Candidate, ...]:
    """The most probable ones that together hold with the wanted probability."""
    total = sum(one.probability for one in ranking)
    chosen, held = [], 0.0
    for one in ranking:
        chosen.append(one)
        held += one.probability / max(total, 1e-300)
        if held >= settings.set_share:
            break
    return tuple(chosen)


def _cause(
    workspace: Workspace,
    chosen: Scored,
    index: int,
    before: FloatArray,
    ranking: Sequence[Candidate],
    settings: DiagnosisSettings,
) -> Cause:
    hypothesis, form = chosen.parts[index]
    if len(chosen.parts) > 1:
        others = [part for at, part in enumerate(chosen.parts) if at != index]
        before, _ = workspace.explained(workspace.scorer.score(others, foretell=False))
    probability = sum(
        one.probability
        for one in ranking
        if (one.effect, one.location) == (hypothesis.effect.identifier, hypothesis.place)
    )
    return Cause(
        effect=hypothesis.effect.identifier,
        group=hypothesis.effect.group,
        location=hypothesis.place,
        probability=probability,
        size=sizes(workspace, chosen, index, settings.size_error),
        run=form.shape.run,
        shrink=shrink(workspace, before, workspace.explained(chosen)[0]),
        hidden_cop_mm=1e3 * hidden_cop(workspace, chosen, index),
    )
