"""The answer: how probable a robot within tolerance is, and what else explains the session."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.diagnosis.hypotheses import Form
from shoecal_core.diagnosis.result import Cause, NamedHypothesis, Verdict
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.selection import (
    LOG_UNMODELLED,
    PLACES_EACH,
    Selection,
    added_evidence,
    best_form,
    fit_without,
    over_all_runs,
    select,
    without,
)
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import FORCE_AND_PLACE, excess, gap, judged_runs, shrink
from shoecal_core.diagnosis.sizes import sizes
from shoecal_core.diagnosis.tempering import needed, shares, temper
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP, GRF


def hidden_cop(workspace: Workspace, scored: Scored, index: int) -> float:
    """Mean length of the CoP error that gains and offsets would make up for [m]."""
    added = workspace.added(scored, scored.own(index))
    absorbed = added - workspace.calibrated(added)
    return float(np.linalg.norm(absorbed[workspace.signal_model.mask[:, 1]][:, COP], axis=1).mean())


EXPLAINED_FROM = 0.6
"""Part of the excess that must go on runs left out for a gap to count as explained."""
LIKELY = 0.5
"""Probability from which something is more likely there than not."""
TAKEN_FROM = 1.0 / 3.0
"""Part of what GRF or CoP are off on runs left out that must go with a cause: one that takes less,
however surely, leaves the gap unexplained."""
LEAST_EXCESS = 0.25
"""Excess on runs left out from which there is something to take: errors 12 % larger than expected.
Floors are known no better, and less is worth no repair."""
SURELY = 3.0
"""Excess on runs left out from which something is wrong, whatever the others showed: errors twice
as large as expected."""
PARTS = (GRF, COP, FORCE_AND_PLACE)
"""Signals that a gap is judged in."""
TRIES = 3
"""Explanations that are held against runs left out: who is refuted so often has none."""


@dataclass(frozen=True)
class Answer:
    """What is said.

    Attributes:
        verdict, causes: as in `Diagnosis`.
        ambiguity: what cannot be separated from the first cause, itself included.
        ranking: of everything that could stand in its place.
    """

    verdict: Verdict
    causes: tuple[Cause, ...] = ()
    ambiguity: tuple[NamedHypothesis, ...] = ()
    ranking: tuple[NamedHypothesis, ...] = ()


def answer(
    workspace: Workspace, certain: Sequence[Cause], found: Selection, settings: DiagnosisSettings
) -> Answer:
    """The verdict.

    Args:
        workspace: under the wiring that was found and with a stuck cell's readings corrected.
        certain: causes that no fit was needed for.
    """
    ranking = probabilities(found, 0) if found.alternatives else ()
    causes = [*certain, *causes_of(workspace, found)]
    if not causes:
        there = _has_gap(workspace, evident=found.unmodelled >= needed(settings))
        return Answer("unknown" if there else "no_gap", ranking=ranking)
    ambiguity = ambiguity_set(ranking, settings) if found.chosen is not None else ()
    if certain:
        first = certain[0]
        ambiguity = (NamedHypothesis(first.effect, first.location, first.probability),)
        ranking = (*ambiguity, *ranking)
    verdict: Verdict = "ambiguous" if len(ambiguity) > 1 else "explained"
    if found.chosen is not None:
        left = _partly(workspace, found.chosen, settings)
    else:
        left = _has_gap(workspace, evident=found.unmodelled >= needed(settings))
    if left:
        verdict = "partly_explained"
    return Answer(verdict, tuple(causes), ambiguity, ranking)


def confirmed(
    workspace: Workspace, found: Selection, settings: DiagnosisSettings
) -> tuple[Selection, tuple[str, ...]]:
    """Without causes that runs left out do not confirm, or in whose place there may be nothing.

    Where the first one is, a robot within tolerance has to be improbable enough; a further one has
    to be likely by itself, since only of the first one all that cannot be separated from it is
    listed.

    Returns:
        What stays, and in words what went.
    """
    chosen = found.chosen
    if chosen is None:
        return found, ()
    found = replace(
        found, predicted=tuple(_predicted(workspace, found, at) for at in range(len(chosen.parts)))
    )
    for index, (hypothesis, form) in reversed(list(enumerate(chosen.parts))):
        rivals = probabilities(found, index)
        probable = sum(one.probability for one in rivals)
        own = sum(one.probability for one in rivals if one.effect == hypothesis.effect.identifier)
        why, unmodelled = "", found.unmodelled
        if probable < (LIKELY if index else 1.0 - settings.false_alarms):
            why = f"with {1.0 - probable:.0%} it is an error that any robot may be built with"
        elif index and own < LIKELY:
            why = f"with {1.0 - own:.0%} it is another effect that comes on top"
        if _shown_by_test_runs(workspace, form):
            *each, (_, gone) = _taken(workspace, chosen, index)
            off = [(there, less) for there, less in each if there > LEAST_EXCESS]
            shrinks = gone > 0.0 and any(less >= TAKEN_FROM * there for there, less in off)
            if not shrinks or found.predicted[index] <= 0.0:
                why = "explains training runs, but test runs do not confirm it"
                # Not that, but something: a robot within tolerance is as improbable as before.
                if off:
                    unmodelled = max(unmodelled, chosen.evidence)
        if why:
            left = replace(without(workspace, found, index), unmodelled=unmodelled)
            left, others = confirmed(workspace, left, settings)
            return left, (f"{hypothesis.label}: {why}: not named", *others)
    return found, ()


def first_confirmed(
    workspace: Workspace, settings: DiagnosisSettings
) -> tuple[Selection, tuple[str, ...]]:
    """The most probable explanation that runs left out confirm; and in words which they do not.

    Where they confirm none, the ranking is that of all hypotheses.
    """
    singles = over_all_runs(workspace, None)
    first: Selection | None = None
    denied: dict[str, None] = {}
    for _ in range(TRIES):
        found = select(workspace, settings, singles)
        named, reasons = confirmed(workspace, found, settings)
        denied |= dict.fromkeys(reasons)
        if named.chosen is not None:
            return named, tuple(denied)
        first = first or named
        if found.chosen is None:
            break
        refuted = [hypothesis for hypothesis, _ in found.chosen.parts]
        singles = [one for one in singles if not any(one.part[0] is each for each in refuted)]
    assert first is not None
    return first, tuple(denied)


def _shown_by_test_runs(workspace: Workspace, form: Form) -> bool:
    """Whether runs left out show it: what happened once, in a run that was fitted, they do not."""
    return bool(workspace.test) and form.shape.run is None


def _predicted(workspace: Workspace, found: Selection, index: int) -> float:
    """Logarithm of the probability of the runs left out with a cause, against without it."""
    assert found.chosen is not None
    if not _shown_by_test_runs(workspace, found.chosen.parts[index][1]):
        return 0.0
    left, scorer = fit_without(workspace, found.chosen, index), workspace.scorer
    others = (left,) if left is not None else (scorer.nothing, scorer.unmodelled)
    chosen, *least = (workspace.predicted(one, bounded=True) for one in (found.chosen, *others))
    return chosen - max(least)


def _taken(workspace: Workspace, chosen: Scored, index: int) -> list[tuple[float, float]]:
    """Of `PARTS`, the excess on the test runs without a cause, and what of it goes with it."""
    now = workspace.at(chosen)
    before, after = now.without(chosen, index), now.explained(chosen)[0]
    without = [excess(now, before, now.test, part) for part in PARTS]
    left = [excess(now, after, now.test, part) for part in PARTS]
    return [(there, there - rest) for there, rest in zip(without, left, strict=True)]


def causes_of(workspace: Workspace, found: Selection) -> list[Cause]:
    """All parts of what was chosen, with sizes, shrink and hidden part."""
    if found.chosen is None:
        return []
    return [
        _cause(workspace, found.chosen, index, probabilities(found, index))
        for index in range(len(found.alternatives))
    ]


def causes_asked_for(workspace: Workspace, found: Selection) -> list[Cause]:
    """Every hypothesis by itself, needed or not, the most probable first; of an effect at many
    places the first few. One whose size makes no sense, as a negative delay, comes last.
    """
    ranking = probabilities(found, 0) if found.alternatives else ()
    alone = [one.scored for one in found.singles]
    shown = [one.parts[0][0] for one in alone]
    alone += [
        best_form(workspace, hypothesis)
        for hypothesis in workspace.catalogue.hypotheses
        if not any(hypothesis is other for other in shown)
    ]
    seen: Counter[str] = Counter()
    causes = []
    for scored in alone:
        effect = scored.parts[0][0].effect.identifier
        seen[effect] += 1
        if seen[effect] <= PLACES_EACH:
            causes.append(_cause(workspace.at(scored), scored, 0, ranking))
    return causes


def probabilities(found: Selection, index: int) -> tuple[NamedHypothesis, ...]:
    """Of everything that could stand in a cause's place; what lacks is that there is none.

    What a cause explains next to much stronger ones may be an error in their form; an
    unmodelled term has none. Runs left out speak for all of them or for none.
    """
    alternatives = found.alternatives[index]
    best = max((log for _, log in alternatives), default=0.0)
    together = _named_evidence(found.chosen) if found.chosen is not None else 0.0
    counts = temper(max(best, together))
    against = found.predicted[index] if found.predicted else 0.0
    each = shares([*(counts * log for _, log in alternatives), -counts * against])
    return tuple(
        NamedHypothesis(hypothesis.effect.identifier, hypothesis.place, float(share))
        for (hypothesis, _), share in zip(alternatives, each, strict=False)
    )


def _named_evidence(chosen: Scored) -> float:
    return chosen.evidence - (chosen.scorer.unmodelled.evidence if chosen.unmodelled else 0.0)


def ambiguity_set(
    ranking: Sequence[NamedHypothesis], settings: DiagnosisSettings
) -> tuple[NamedHypothesis, ...]:
    """The most probable ones that together hold with the wanted probability."""
    total = sum(one.probability for one in ranking)
    chosen, held = [], 0.0
    for one in ranking:
        chosen.append(one)
        held += one.probability / max(total, 1e-300)
        if held >= settings.set_share:
            break
    return tuple(chosen)


def _has_gap(workspace: Workspace, *, evident: bool) -> bool:
    """Whether CoP or GRF are off on runs left out by more than those of a robot within tolerance.

    Args:
        evident: the training runs show that something is wrong; else it takes twice as much.
    """
    rest = workspace.explained(None)[0]
    if not evident:
        # Forces that are far off are no less so where the CoP is not, and the other way round.
        return any(excess(workspace, rest, judged_runs(workspace), part) > SURELY for part in PARTS)
    size = gap(workspace, rest)
    return size.cop_mae_mm > size.cop_floor_mm or size.grf_mae_n > size.grf_floor_n


def _partly(workspace: Workspace, chosen: Scored, settings: DiagnosisSettings) -> bool:
    """Whether something is left; what happened once, in a run that was fitted, does not count."""
    if chosen.unmodelled:
        alone = workspace.scorer.score(chosen.parts, start=chosen)
        if added_evidence(chosen, alone) + LOG_UNMODELLED >= needed(settings):
            return True
    happened = any(form.shape.run is not None for _, form in chosen.parts)
    if happened or not _has_gap(workspace, evident=True):
        return False
    before, after = workspace.explained(None)[0], workspace.explained(chosen)[0]
    return shrink(workspace, before, after).fraction < EXPLAINED_FROM


def _cause(
    workspace: Workspace, chosen: Scored, index: int, ranking: Sequence[NamedHypothesis]
) -> Cause:
    hypothesis, form = chosen.parts[index]
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
        size=sizes(workspace, chosen, index),
        run=form.shape.run,
        shrink=shrink(workspace, workspace.without(chosen, index), workspace.explained(chosen)[0]),
        hidden_cop_mm=1e3 * hidden_cop(workspace, chosen, index),
    )
