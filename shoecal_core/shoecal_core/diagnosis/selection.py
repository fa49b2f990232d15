"""Which effects are needed: one after the other, each in the company of those found before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.scoring import Part, Scored
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP

FloatArray = NDArray[np.float64]
FAR_MORE = 1.5
"""Times the evidence of the best that matters, from which one that does not is taken first."""
LOOKED_AT = 40
"""Hypotheses that are looked at in full, the most probable ones."""
STARTS, START_FROM = 10, 0.25
"""Effects that pairs are begun with, each at its best place, and the least share of the best
one's evidence that they have by themselves."""
PARTNERS = 3
"""Partners of each that are looked at in full."""


@dataclass(frozen=True)
class Found:
    """What was selected.

    Attributes:
        chosen: all causes together; None when nothing is needed.
        alternatives: of each cause, every hypothesis in its place beside the other causes, the
            best first, with the logarithm of its evidence against having nothing there.
        singles: every hypothesis by itself, the best first.
    """

    chosen: Scored | None
    alternatives: tuple[tuple[tuple[Hypothesis, float], ...], ...]
    singles: tuple[Scored, ...]


def select(workspace: Workspace, settings: DiagnosisSettings) -> Found:
    """Forward, one at a time; then each is tried again beside the others, and pruned.

    What explains most by itself may be a mixture of two others, so the second step looks at pairs
    that other effects begin as well.
    """
    parts: list[Part] = []
    before = workspace.scorer.score(())
    singles = ranked(workspace, settings)
    while len(parts) < settings.causes_max:
        candidates = ranked(workspace, settings, parts) if parts else singles
        if len(parts) == 1:
            candidates = sorted([*candidates[:1], *_pairs(workspace, settings)], key=whole)[::-1]
        if not candidates or not is_needed(candidates[0], before, settings):
            break
        before = candidates[0]
        parts = list(before.parts)
    parts = _revised(workspace, parts, settings)
    parts = _by_weight(workspace, parts)
    if not parts:
        return Found(None, (), tuple(singles))
    return Found(
        workspace.scorer.score(parts),
        tuple(_alternatives(workspace, parts, index, settings) for index in range(len(parts))),
        tuple(singles),
    )


def asked_for(workspace: Workspace) -> Found:
    """The best of what is looked at, needed or not: for who asks of one effect how it would do."""
    scored = [workspace.scorer.best_form(one) for one in workspace.catalogue.hypotheses]
    scored.sort(key=weight, reverse=True)
    if not scored:
        return Found(None, (), ())
    weights = tuple((one.parts[-1][0], weight(one)) for one in scored)
    return Found(scored[0], (weights,), tuple(scored))


def ranked(
    workspace: Workspace, settings: DiagnosisSettings, beside: Sequence[Part] = ()
) -> list[Scored]:
    """Hypotheses that make sense and matter, beside some that stay; the most probable first."""
    taken = {id(hypothesis) for hypothesis, _ in beside}
    without = workspace.scorer.score(beside, foretell=False)
    scored = [
        _believable(without, hypothesis)
        for hypothesis in workspace.catalogue.hypotheses
        if id(hypothesis) not in taken
    ]
    before, _ = workspace.explained(without)
    likely = sorted((one for one in scored if one.sensible), key=weight, reverse=True)[:LOOKED_AT]
    found = [one for one in likely if matters(workspace, settings, before, without, one)]
    # What is far more probable than all that matters would only be replaced by something wrong.
    if not beside and found and weight(likely[0]) > FAR_MORE * weight(found[0]):
        found.insert(0, likely[0])
    return found


def _pairs(workspace: Workspace, settings: DiagnosisSettings) -> list[Scored]:
    """Each of the likeliest effects with the partner that suits it best, both of which matter."""
    scorer, hypotheses = workspace.scorer, workspace.catalogue.hypotheses
    alone = [scorer.best_form(one, full=False) for one in hypotheses]
    firsts: dict[str, Scored] = {}
    alone.sort(key=lambda one: one.evidence, reverse=True)
    for one in alone:
        if one.evidence > START_FROM * alone[0].evidence:
            firsts.setdefault(one.parts[0][0].effect.identifier, one)
    found = []
    for first in list(firsts.values())[:STARTS]:
        partners = [
            scorer.best_form(one, first.parts, foreseen=True, full=False)
            for one in hypotheses
            if one is not first.parts[0][0]
        ]
        partners.sort(key=lambda one: one.evidence, reverse=True)
        before, _ = workspace.explained(first)
        pairs = [scorer.score(one.parts) for one in partners[:PARTNERS] if one.sensible]
        found += [one for one in pairs if matters(workspace, settings, before, first, one)]
    return found


def _believable(without: Scored, hypothesis: Hypothesis) -> Scored:
    """Its best form beside others; if read from the signals, one that explains it twice over.

    A robot without a fault wanders a little too, and what reads its wandering explains some of it.
    """
    scorer = without.scorer
    best = scorer.best_form(hypothesis, without.parts)
    if best.evidence - without.evidence >= best.parts[-1][1].shape.spent:
        return best
    return scorer.best_form(hypothesis, without.parts, foreseen=True)


def matters(
    workspace: Workspace,
    settings: DiagnosisSettings,
    before: FloatArray,
    without: Scored,
    scored: Scored,
) -> bool:
    """Whether the part that was added last does; what may be a remainder of others must do more.

    Args:
        before: (T, s) residuals without it. without: the others' fit.
    """
    least = settings.material
    if without.parts:
        added = scored.evidence - without.evidence
        remainder = added < settings.remainder_share * without.evidence
        least = settings.later_material if remainder else settings.other_material
    return matter(workspace, before, scored) >= least


def happened(workspace: Workspace, found: Found, settings: DiagnosisSettings) -> bool:
    """Whether one of the causes is something that happened once, and matters in its run."""
    parts = found.chosen.parts if found.chosen is not None else ()
    for index, part in enumerate(parts):
        if part[1].shape.run is not None:
            others = [*parts[:index], *parts[index + 1 :]]
            before, _ = workspace.explained(workspace.scorer.score(others, foretell=False))
            scored = workspace.scorer.score([*others, part], foretell=False)
            if matter(workspace, before, scored) >= settings.material:
                return True
    return False


def whole(scored: Scored) -> float:
    """As `weight`, with the priors of all parts."""
    others = sum(math.log(hypothesis.prior) for hypothesis, _ in scored.parts[:-1])
    return weight(scored) + others


def weight(scored: Scored) -> float:
    """Evidence and what runs left out say of the part that was added last, and its prior.

    A hypothesis must do well by both: the mean of the two, each a logarithm of how much more
    probable the data are with it.
    """
    hypothesis, form = scored.parts[-1]
    told = scored.evidence
    if form.shape.run is None:
        told = 0.5 * (scored.evidence + min(scored.foretold, scored.evidence))
    return told + math.log(hypothesis.prior)


def matter(workspace: Workspace, before: FloatArray, scored: Scored) -> float:
    """How much of CoP or GRF, whichever is more, one more part explains, over what none does.

    What is sure but too small to matter to a controller is no gap. What gains and offsets would
    make up for is no gap either: it is told by itself, as hidden.

    Args:
        before: (T, s) residuals without it.
    """
    after, _ = workspace.explained(scored)
    rows = workspace.scene.mask[:, 1].copy()
    run = scored.parts[-1][1].shape.run
    if run is not None:
        rows &= workspace.rows_of([run])
    if not rows.any():
        return 0.0
    change = (before - after)[rows] / workspace.beyond_all
    cop = float(np.sqrt(np.mean(change[:, COP] ** 2)))
    return max(cop, float(np.sqrt(np.mean(change[:, 0] ** 2))))


def _revised(workspace: Workspace, parts: list[Part], settings: DiagnosisSettings) -> list[Part]:
    """Each part again beside the others: replaced by a better one, or dropped if not needed."""
    for _ in range(len(parts)):
        for index in reversed(range(len(parts))):
            others = [part for at, part in enumerate(parts) if at != index]
            without = workspace.scorer.score(others)
            candidates = ranked(workspace, settings, others)
            if not candidates or not is_needed(candidates[0], without, settings):
                return _revised(workspace, others, settings)
            parts = [*others, candidates[0].parts[-1]]
    return parts


def is_needed(scored: Scored, without: Scored, settings: DiagnosisSettings) -> bool:
    """Whether the part added last is, by the evidence and by what runs left out are foretold."""
    needed = max(settings.evidence_min, settings.later_share * without.evidence)
    gains = [scored.evidence - without.evidence]
    if scored.parts[-1][1].shape.run is None and scored.scorer.foretells:
        gains.append(scored.foretold - without.foretold)
    return min(gains) >= needed


def _by_weight(workspace: Workspace, parts: list[Part]) -> list[Part]:
    """The parts without which the others explain least come first."""
    without = [
        workspace.scorer.score(parts[:at] + parts[at + 1 :], foretell=False).evidence
        for at in range(len(parts))
    ]
    return [parts[at] for at in np.argsort(without, kind="stable")]


def _alternatives(
    workspace: Workspace, parts: list[Part], index: int, settings: DiagnosisSettings
) -> tuple[tuple[Hypothesis, float], ...]:
    others = [part for at, part in enumerate(parts) if at != index]
    without = workspace.scorer.score(others, foretell=False).evidence if others else 0.0
    rivals = ranked(workspace, settings, others)
    if all(scored.parts[-1][0] is not parts[index][0] for scored in rivals):
        # Beside the others it may fit in another form: what was chosen is always among them.
        rivals = sorted(
            [workspace.scorer.score([*others, parts[index]]), *rivals], key=weight, reverse=True
        )
    return tuple((scored.parts[-1][0], weight(scored) - without) for scored in rivals)
