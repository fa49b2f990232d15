"""Which effects are needed: the most probable one, then each further one with the others kept.

Everything is scored in two ways: that nothing but it is wrong, or that an unmodelled term is there
as well (`scoring`). What explains most at a quick look is fitted in full.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.scoring import Part, Scored, Scorer
from shoecal_core.diagnosis.settings import ARM_M, DiagnosisSettings
from shoecal_core.diagnosis.tempering import needed
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP, GRF

LOG_UNMODELLED = math.log(0.05)
"""Of the probability, beforehand, that something is there which the library has not."""
LOOKED_AT, PLACES_EACH = 14, 5
"""Hypotheses that are fitted in full, and of one effect at most."""
TESTED = 6
"""Of the most probable ones by the runs that were fitted, on runs left out."""
SENSED = frozenset(("load_cell", "timing"))
"""Groups of effects whose laws can stand for each other at one place."""
LEAST_GAIN = -1.0
"""Log evidence at a quick look below which an effect is not fitted in full for its own sake."""


@dataclass(frozen=True)
class Ranked:
    """A hypothesis in addition to the other causes.

    Attributes:
        scored: the other causes with it, in the more probable of both ways.
        log: logarithm of its probability against the others alone, its prior included.
        before: those others; without any a robot within tolerance or an unmodelled term,
            whichever is the more probable.
        predicted: logarithm of the probability of the runs left out with it, against without it;
            zero as long as they have not been looked at, and for what happened in one run.
    """

    scored: Scored
    log: float
    before: Scored
    predicted: float = 0.0

    @property
    def total(self) -> float:
        """Logarithm of its probability by all runs: those that were fitted, and those left out."""
        return self.log + self.predicted

    @property
    def part(self) -> Part:
        """What was added to the other causes."""
        return self.scored.parts[-1]


@dataclass(frozen=True)
class Selection:
    """What was selected.

    Attributes:
        chosen: all causes together; None when nothing is needed, or nothing known suffices.
        alternatives: for each cause, every hypothesis in its place with the other causes kept, the
            most probable first, with the logarithm of its probability against having none there.
        singles: every hypothesis by itself, the most probable first.
        unmodelled: logarithm of the probability that what was not chosen moves CoP or GRF,
            against a robot within tolerance.
        predicted: for each cause, logarithm of the probability of the runs left out against having
            none there; empty as long as they have not been looked at.
    """

    chosen: Scored | None
    alternatives: tuple[tuple[tuple[Hypothesis, float], ...], ...]
    singles: tuple[Ranked, ...]
    unmodelled: float
    predicted: tuple[float, ...] = ()

    def stands(self, scorer: Scorer, settings: DiagnosisSettings) -> Scored:
        """What is most probable: the causes, an unmodelled term, or a robot within tolerance."""
        if self.chosen is not None:
            return self.chosen
        return scorer.unmodelled if self.unmodelled >= needed(settings) else scorer.nothing


def select(
    workspace: Workspace, settings: DiagnosisSettings, singles: Sequence[Ranked] | None = None
) -> Selection:
    """Forward, one at a time; then what the others make superfluous goes.

    Args:
        workspace: all hypotheses.
        settings: of the diagnosis.
        singles: those that may come first, each ranked by itself; None: all.
    """
    singles = over_all_runs(workspace, None) if singles is None else singles
    chosen: Scored | None = None
    ranked = singles
    while chosen is None or len(chosen.parts) < settings.causes_max:
        at = _first(workspace, ranked, settings)
        if at is None:
            break
        if chosen is None:
            # What explains nearly nothing, however surely, is no alternative.
            singles = singles[at:]
        chosen = ranked[at].scored
        if len(chosen.parts) < settings.causes_max:
            ranked = over_all_runs(workspace, chosen)
    if chosen is not None:
        chosen = _pruned(workspace, chosen, settings)
    found = _found(workspace, chosen, singles)
    sure = [one for one in singles if one.log >= needed(settings)]
    if chosen is None and any(material(workspace, one.scored, settings) for one in sure):
        # None of these explains it, but they say that something is there.
        found = replace(found, unmodelled=max(found.unmodelled, sure[0].log))
    return found


def _first(
    workspace: Workspace, ranked: Sequence[Ranked], settings: DiagnosisSettings
) -> int | None:
    """Place of the most probable hypothesis that is evident and matters.

    Of several that nearly look alike none is evident by itself, but all together are.
    """
    together = np.logaddexp.reduce([-np.inf, *(one.total for one in ranked)])
    for at, one in enumerate(ranked):
        if together < needed(settings) or one.total <= 0.0:
            return None
        if material(workspace, one.scored, settings):
            return at
    return None


def without(workspace: Workspace, found: Selection, index: int) -> Selection:
    """Without one of the causes that were chosen."""
    assert found.chosen is not None
    left = fit_without(workspace, found.chosen, index)
    alternatives = _alternatives(workspace, left, found.singles)
    return replace(found, chosen=left, alternatives=alternatives, predicted=())


def fit_without(workspace: Workspace, chosen: Scored, index: int) -> Scored | None:
    """All parts but one; None where none is left."""
    others = [part for at, part in enumerate(chosen.parts) if at != index]
    if not others:
        return None
    near = workspace.scorer.score(others, unmodelled=chosen.unmodelled, start=chosen)
    ways = (near if near.sensible else None, _best_way(workspace, others, None))
    return max((way for way in ways if way is not None), key=value, default=None)


def asked_for(workspace: Workspace) -> Selection:
    """The best of what is looked at, needed or not: for who asks of one effect how it would do."""
    singles = rank(workspace, None, most=len(workspace.catalogue.hypotheses), each=None)
    return _found(workspace, singles[0].scored if singles else None, singles)


def best_form(workspace: Workspace, hypothesis: Hypothesis) -> Scored:
    """A hypothesis by itself in its most probable form, whether or not its size makes sense."""
    scored = [workspace.scorer.score([(hypothesis, form)]) for form in hypothesis.forms]
    return max(scored, key=value)


def _found(workspace: Workspace, chosen: Scored | None, singles: Sequence[Ranked]) -> Selection:
    scorer = workspace.scorer
    return Selection(
        chosen,
        _alternatives(workspace, chosen, singles),
        tuple(singles),
        added_evidence(scorer.unmodelled, scorer.nothing) + LOG_UNMODELLED,
    )


def rank(
    workspace: Workspace,
    others: Scored | None,
    most: int = LOOKED_AT,
    each: int | None = PLACES_EACH,
) -> list[Ranked]:
    """Hypotheses that make sense in addition to others that stay, the most probable first.

    Args:
        others: causes that stay; None: a robot within tolerance.
        most: fitted in full, and one of each other effect that explains anything.
        each: places of one effect at most.
    """
    scorer = workspace.scorer
    before = others or max((scorer.nothing, scorer.unmodelled), key=value)
    parts = [one for one, _ in others.parts] if others is not None else []
    effects = {one.effect.identifier for one in parts}
    places = {(one.effect.group, one.place) for one in parts if one.effect.group in SENSED}
    # What an effect leaves of itself at another place is no second one; nor is what is left of a
    # cell's law that has another form than the library has it in.
    further = [
        one
        for one in workspace.catalogue.hypotheses
        if one.effect.identifier not in effects and (one.effect.group, one.place) not in places
    ]
    glances = scorer.gains(further, others)
    glances.sort(key=lambda one: one.gain + math.log(one.parts[0][0].prior), reverse=True)
    seen: Counter[str] = Counter()
    found = []
    for at, glance in enumerate(glances):
        hypothesis = glance.parts[0][0]
        effect = hypothesis.effect.identifier
        if at >= most and (seen[effect] or glance.gain < LEAST_GAIN):
            continue
        if each is not None and seen[effect] >= each:
            continue
        seen[effect] += 1
        kept = others.parts if others is not None else ()
        ways = [_best_way(workspace, (*kept, part), others) for part in glance.parts]
        scored = max((way for way in ways if way is not None), key=value, default=None)
        if scored is not None:
            log = value(scored) - value(before) + glance.alike + math.log(hypothesis.prior)
            found.append(Ranked(scored, log, before))
    found.sort(key=lambda one: one.log, reverse=True)
    return found


def over_all_runs(workspace: Workspace, others: Scored | None) -> list[Ranked]:
    """The same, by how probable runs left out are with each as well: the most probable first.

    Tolerance errors are as large there as the fit has them, with a cause and without: by the chain
    rule this is the evidence of all runs.
    """
    scorer, found = workspace.scorer, rank(workspace, others)
    if workspace.test:
        before = (others,) if others is not None else (scorer.nothing, scorer.unmodelled)
        least = max(workspace.predicted(one, bounded=False) for one in before)
        for at, one in enumerate(found[:TESTED]):
            if one.part[1].shape.run is None:
                log = workspace.predicted(one.scored, bounded=False)
                found[at] = replace(one, predicted=log - least)
    return sorted(found, key=lambda one: one.total, reverse=True)


def value(scored: Scored) -> float:
    """Evidence, and what an unmodelled term costs beforehand where it is there as well."""
    return scored.evidence + (LOG_UNMODELLED if scored.unmodelled else 0.0)


def added_evidence(scored: Scored, before: Scored) -> float:
    """Log likelihood by which CoP and GRF are better explained than before."""
    here = np.isin(scored.scorer.rows.signal, np.r_[GRF, COP])
    return float((scored.log_likelihood - before.log_likelihood)[here].sum())


def material(workspace: Workspace, scored: Scored, settings: DiagnosisSettings) -> bool:
    """Whether a calibration leaves so much of the part that was added last that it matters.

    What is sure but too small for that is no gap, nor what only legs or plates show. It matters on
    the runs that were fitted or on those left out, which a drift shows more; what happened in one
    run counts there.
    """
    added = workspace.calibrated(workspace.added(scored, scored.own(len(scored.parts) - 1)))
    run = scored.parts[-1][1].shape.run
    sets = (workspace.train, workspace.test) if run is None else ((run,),)
    return any(_moves(workspace, added, runs) >= settings.material_m for runs in sets)


def _moves(workspace: Workspace, added: FloatArray, runs: Sequence[int]) -> float:
    """RMS of what residuals (T, s) are moved by on some runs, as an error of the CoP [m]."""
    here = added[workspace.rows_of(runs) & workspace.signal_model.mask[:, 1]]
    if not len(here):
        return 0.0
    cop = float(np.sqrt((here[:, COP] ** 2).sum(axis=1).mean()))
    share = float(np.sqrt((here[:, GRF] ** 2).mean())) / workspace.signal_model.samples.robot.weight
    return max(cop, ARM_M * share)


def _best_way(workspace: Workspace, parts: Sequence[Part], others: Scored | None) -> Scored | None:
    """Without or with an unmodelled term in addition, whichever is more probable."""
    scorer = workspace.scorer
    # Where nothing else is seen, nothing else is seen next to an effect.
    seen = scorer.unmodelled.evidence > 0.0 if others is None else others.unmodelled
    both = (False, True) if seen else (False,)
    ways = [scorer.score(parts, unmodelled=one, start=others) for one in both]
    return max((way for way in ways if way.sensible), key=value, default=None)


def _pruned(workspace: Workspace, chosen: Scored, settings: DiagnosisSettings) -> Scored:
    """Without parts that the others make superfluous."""
    for index in range(len(chosen.parts)) if len(chosen.parts) > 1 else ():
        left = fit_without(workspace, chosen, index)
        if left is not None and value(chosen) - value(left) < needed(settings):
            return _pruned(workspace, left, settings)
    return chosen


def _alternatives(
    workspace: Workspace, chosen: Scored | None, singles: Sequence[Ranked]
) -> tuple[tuple[tuple[Hypothesis, float], ...], ...]:
    if chosen is None:
        return (tuple((one.part[0], one.total) for one in singles),) if singles else ()
    found = []
    for index, (hypothesis, _) in enumerate(chosen.parts):
        alone = len(chosen.parts) == 1
        rivals = (
            singles if alone else over_all_runs(workspace, fit_without(workspace, chosen, index))
        )
        # By the fitted runs, were those left out to say of all what they say of the chosen one.
        own = next((one.predicted for one in rivals if one.part[0] is hypothesis), 0.0)
        found.append(tuple((one.part[0], one.total - own) for one in rivals))
    return tuple(found)
