"""Which effects are needed: one after the other, each in the company of those found before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.scoring import Part, Scored
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.signals import COP
from shoecal_core.diagnosis.workspace import Workspace


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
    """Forward, one at a time; then each is tried again beside the others, and pruned."""
    parts: list[Part] = []
    score = 0.0
    singles = ranked(workspace, settings)
    while len(parts) < settings.causes_max:
        candidates = ranked(workspace, settings, parts) if parts else singles
        if not candidates or candidates[0].evidence - score < settings.evidence_min:
            break
        parts, score = list(candidates[0].parts), candidates[0].evidence
    parts = _revised(workspace, parts, settings)
    if not parts:
        return Found(None, (), tuple(singles))
    return Found(
        workspace.scorer.score(parts),
        tuple(_alternatives(workspace, parts, index, settings) for index in range(len(parts))),
        tuple(singles),
    )


def ranked(
    workspace: Workspace, settings: DiagnosisSettings, beside: Sequence[Part] = ()
) -> list[Scored]:
    """Every hypothesis that matters, beside some that stay; the most probable first."""
    taken = {id(hypothesis) for hypothesis, _ in beside}
    scored = [
        workspace.scorer.best_form(hypothesis, beside)
        for hypothesis in workspace.library.hypotheses
        if id(hypothesis) not in taken
    ]
    mattering = [
        one for one in scored if one.sensible and material(workspace, one, len(beside), settings)
    ]
    return sorted(mattering, key=weight, reverse=True)


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


def material(workspace: Workspace, scored: Scored, index: int, settings: DiagnosisSettings) -> bool:
    """Whether a part changes CoP or GRF by more than a share of their noise.

    What is sure but too small to matter to a controller is no gap.
    """
    return matter(workspace, scored, index) >= settings.material


def matter(workspace: Workspace, scored: Scored, index: int) -> float:
    """How much a part changes of CoP or GRF, whichever is more, over the floor of their noise."""
    cop, grf = contribution(workspace, scored, index)
    floor = workspace.floor
    return max(cop / float(np.sqrt((floor[COP] ** 2).mean())), grf / float(floor[0]))


def contribution(workspace: Workspace, scored: Scored, index: int) -> tuple[float, float]:
    """Root mean square of what a part changes of one axis of the CoP [m], and of the GRF [N]."""
    _, form = scored.parts[index]
    sizes = scored.sizes[scored.own(index)]
    places = np.array(form.columns)
    return tuple(  # type: ignore[return-value]
        float(np.sqrt(max(sizes @ workspace.powers[signal][np.ix_(places, places)] @ sizes, 0.0)))
        for signal in ("cop", "grf")
    )


def _revised(workspace: Workspace, parts: list[Part], settings: DiagnosisSettings) -> list[Part]:
    """Each part again beside the others: replaced by a better one, or dropped if not needed."""
    for index in reversed(range(len(parts))):
        if len(parts) == 1:
            break
        others = [part for at, part in enumerate(parts) if at != index]
        without = workspace.scorer.score(others, foretell=False).evidence
        candidates = ranked(workspace, settings, others)
        if not candidates or candidates[0].evidence - without < settings.evidence_min:
            parts = others
        else:
            parts = [*others, candidates[0].parts[-1]]
    return parts


def _alternatives(
    workspace: Workspace, parts: list[Part], index: int, settings: DiagnosisSettings
) -> tuple[tuple[Hypothesis, float], ...]:
    others = [part for at, part in enumerate(parts) if at != index]
    without = workspace.scorer.score(others, foretell=False).evidence if others else 0.0
    return tuple(
        (scored.parts[-1][0], weight(scored) - without)
        for scored in ranked(workspace, settings, others)
    )
