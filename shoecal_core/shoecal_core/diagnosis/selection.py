"""Which effects are needed: one after the other, each in the company of those found before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.signals import COP
from shoecal_core.diagnosis.workspace import Workspace

FloatArray = NDArray[np.float64]
Part = tuple[Hypothesis, Form]


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
    singles = ranked(workspace)
    while len(parts) < settings.causes_max:
        candidates = ranked(workspace, parts) if parts else singles
        best = _best(workspace, candidates, len(parts), settings)
        if best is None or best.evidence - score < settings.evidence_min:
            break
        parts, score = list(best.parts), best.evidence
    parts = _revised(workspace, parts, settings)
    if not parts:
        return Found(None, (), tuple(singles))
    chosen = workspace.scorer.score(parts)
    return Found(
        chosen,
        tuple(_alternatives(workspace, parts, index) for index in range(len(parts))),
        tuple(singles),
    )


def ranked(workspace: Workspace, beside: Sequence[Part] = ()) -> list[Scored]:
    """Every hypothesis beside some that stay, the most probable first."""
    taken = {id(hypothesis) for hypothesis, _ in beside}
    scored = [
        workspace.scorer.best_form(hypothesis, beside)
        for hypothesis in workspace.library.hypotheses
        if id(hypothesis) not in taken
    ]
    return sorted(scored, key=weight, reverse=True)


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


def _best(
    workspace: Workspace, candidates: Sequence[Scored], index: int, settings: DiagnosisSettings
) -> Scored | None:
    for scored in candidates[:_TRIED]:
        if material(workspace, scored, index, settings):
            return scored
    return None


_TRIED = 8
"""Hypotheses that are looked at for one that matters, the most probable first."""


def material(workspace: Workspace, scored: Scored, index: int, settings: DiagnosisSettings) -> bool:
    """Whether a part changes CoP or GRF by more than a share of their noise.

    What is sure but too small to matter to a controller is no gap.
    """
    cop, grf = contribution(workspace, scored, index)
    noise = workspace.noise.std
    cop_noise = float(np.sqrt((noise[COP] ** 2).mean()))
    return cop >= settings.material * cop_noise or grf >= settings.material * float(noise[0])


def contribution(workspace: Workspace, scored: Scored, index: int) -> tuple[float, float]:
    """Root mean square of what a part changes of one axis of the CoP [m], and of the GRF [N]."""
    _, form = scored.parts[index]
    sizes = scored.solution.vector[scored.own(index)]
    added = np.tensordot(sizes, workspace.library.columns[list(form.columns)], 1)
    mask = workspace.scene.mask
    cop = added[:, COP][mask[:, COP]]
    return float(np.sqrt(np.mean(cop**2))), float(np.sqrt(np.mean(added[mask[:, 0], 0] ** 2)))


def _revised(workspace: Workspace, parts: list[Part], settings: DiagnosisSettings) -> list[Part]:
    """Each part again beside the others: replaced by a better one, or dropped if not needed."""
    for index in reversed(range(len(parts))):
        if len(parts) == 1:
            break
        others = [part for at, part in enumerate(parts) if at != index]
        without = workspace.scorer.score(others, foretell=False).evidence
        best = ranked(workspace, others)[0]
        if best.evidence - without < settings.evidence_min or not material(
            workspace, best, len(others), settings
        ):
            parts = others
        else:
            parts = [*others, best.parts[-1]]
    return parts


def _alternatives(
    workspace: Workspace, parts: list[Part], index: int
) -> tuple[tuple[Hypothesis, float], ...]:
    others = [part for at, part in enumerate(parts) if at != index]
    without = workspace.scorer.score(others, foretell=False).evidence if others else 0.0
    return tuple(
        (scored.parts[-1][0], weight(scored) - without) for scored in ranked(workspace, others)
    )
