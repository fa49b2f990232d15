"""The whole procedure: look, preflight, fit, rank, judge, measure the shrink, propose."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.pipeline import split_runs
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.effects.base import Effect, Place
from shoecal_core.diagnosis.effects.known import EFFECTS
from shoecal_core.diagnosis.evidence import evidence
from shoecal_core.diagnosis.hidden import hidden_cop
from shoecal_core.diagnosis.next_motion import propose
from shoecal_core.diagnosis.preflight import preflight
from shoecal_core.diagnosis.result import Candidate, Cause, Diagnosis, NextMotion, Verdict
from shoecal_core.diagnosis.rewiring import Exchange, rewired
from shoecal_core.diagnosis.sampling import load_samples
from shoecal_core.diagnosis.scene import make_scene
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.selection import Found, asked_for, select
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import excess, gap, shrink
from shoecal_core.diagnosis.sizes import sizes
from shoecal_core.diagnosis.stopped import Stopped, stopped
from shoecal_core.diagnosis.tempering import shares, temper
from shoecal_core.diagnosis.weak_cells import weak_cells
from shoecal_core.diagnosis.where import where
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.errors import FileError
from shoecal_core.recording.session import Session

FloatArray = NDArray[np.float64]
Progress = Callable[[str, float], None]
SHOWN = 20
"""Hypotheses that a ranking lists."""
RIVAL_FROM = 0.01
"""Probability from which a hypothesis counts where the next motion is chosen."""


@dataclass(frozen=True)
class Wanted:
    """Which hypotheses are looked at: all, or an effect, or an effect at a place."""

    effect: str
    place: Place | None = None

    def __call__(self, effect: str, place: Place) -> bool:
        """Whether to look at an effect at a place."""
        return effect == self.effect and (self.place is None or place == self.place)


def diagnose(
    session: Session,
    train: Sequence[int] = (),
    test: Sequence[int] = (),
    settings: DiagnosisSettings | None = None,
    *,
    without: frozenset[str] = frozenset(),
    only: Callable[[str, Place], bool] | None = None,
    effects: Sequence[Effect] = EFFECTS,
    progress: Progress | None = None,
) -> Diagnosis:
    """Tell where model and reality differ, and why.

    Args:
        session: recorded.
        train, test: runs; see `split_runs`. Test runs touch no fit and no ranking.
        settings: thresholds.
        without: families of signals left out (`signals.FAMILIES`).
        only: tells of an effect and a place whether to look; None: everywhere (see `Wanted`).
        effects: the library.
        progress: told what is being done and the share done (0 to 1).

    Raises:
        ShoecalError: when the session cannot tell a gap from a parameter at all.
    """
    settings = DiagnosisSettings() if settings is None else settings
    tell = progress or (lambda _text, _share: None)
    train, test = split_runs(session, train, test)
    samples = load_samples(
        session, (*train, *test), settings, lambda text, share: tell(text, 0.2 * share)
    )
    train, test = (tuple(run for run in runs if run in samples.runs) for runs in (train, test))
    tell("fitting with nothing added", 0.2)
    scene = make_scene(samples, first_parameters(samples, train), settings, without)
    wanted = only or (lambda _effect, _place: True)
    workspace = make_workspace(scene, effects, train, test, settings, wanted)
    if only is not None and not (workspace.catalogue.hypotheses or workspace.catalogue.rewired):
        raise FileError(
            session.folder,
            "nothing of what was asked for can be looked at: there is no such place in this robot "
            "and these shoes, or the recording lacks what the effect needs",
        )
    tell("what this session can tell", 0.45)
    halted = _halted(workspace, wanted)
    mended = workspace
    if halted is not None:
        whole = halted.mended(samples)
        scene = make_scene(whole, first_parameters(whole, train), settings, without)
        mended = make_workspace(scene, effects, train, test, settings, wanted)
    before = preflight(mended, settings)
    tell("trying every effect", 0.5)
    exchange = rewired(mended, effects, settings, wanted)
    best = mended if exchange is None else exchange.workspace
    found = select(best, settings) if only is None else asked_for(best)
    tell("measuring the shrink", 0.8)
    certain = weak_cells(best, wanted)
    if exchange is not None:
        certain.insert(0, _exchanged(exchange, mended.explained(None)[0]))
    if halted is not None:
        certain.insert(0, halted.cause(workspace, mended))
    answer = _answer(workspace, best, certain, found, settings)
    if only is not None and not certain:
        told = _causes(best, found, workspace.explained(None)[0], settings)
        answer = replace(answer, causes=tuple(told))
    tell("choosing the next motion", 0.85)
    proposed = _proposed(best, found, answer, settings)
    tell("done", 1.0)
    chosen = found.chosen if answer.causes else None
    without_any, _ = workspace.explained(None)
    return Diagnosis(
        verdict=answer.verdict,
        gap=gap(best, without_any),
        where=where(best, without_any, chosen),
        shrink=shrink(best, without_any, best.explained(chosen)[0]) if answer.causes else None,
        causes=answer.causes,
        ambiguity=answer.ambiguity,
        ranking=answer.ranking[:SHOWN],
        cannot_detect=before.cannot_detect,
        cannot_separate=before.cannot_separate,
        next_motion=proposed,
        train=train,
        test=test,
        notes=samples.notes,
        robot=samples.robot.name,
        shoe=samples.shoe.name,
        evidence=evidence(best, chosen, found.singles),
    )


def _halted(workspace: Workspace, wanted: Callable[[str, Place], bool]) -> Stopped | None:
    """The cell that got stuck, if one did and it is looked for."""
    samples = workspace.scene.samples
    found = stopped(samples)
    if found is None or not wanted("stuck_cell", (samples.shoe.names[found.channel],)):
        return None
    return found


@dataclass(frozen=True)
class _Answer:
    verdict: Verdict
    causes: tuple[Cause, ...] = ()
    ambiguity: tuple[Candidate, ...] = ()
    ranking: tuple[Candidate, ...] = ()


def _answer(
    workspace: Workspace,
    best: Workspace,
    certain: Sequence[Cause],
    found: Found,
    settings: DiagnosisSettings,
) -> _Answer:
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
    causes = [*certain, *_causes(best, found, before, settings)]
    ranking = _probabilities(found, 0, settings) if found.alternatives else ()
    ambiguity = _set(ranking, settings) if ranking else ()
    if certain:
        first = certain[0]
        ambiguity = (Candidate(first.effect, first.location, first.probability),)
        ranking = (*ambiguity, *ranking)
    happened = any(cause.run is not None for cause in causes)
    if not there and not certain and not happened:
        return _Answer("no_gap", ranking=ranking)
    if not causes:
        return _Answer(nothing_fits)
    after, _ = best.explained(found.chosen)
    over, left = excess(best, before), excess(best, after)
    # What happened once, in a run that was fitted, is no gap of the others.
    explained = 1.0 - max(left, 0.0) / over if there and over > 0.0 else 1.0
    if explained < settings.unknown_below and not certain:
        return _Answer(nothing_fits, ranking=ranking)
    verdict: Verdict = "ambiguous" if len(ambiguity) > 1 else "explained"
    if explained < settings.explained_from:
        verdict = "partly_explained"
    return _Answer(verdict, tuple(causes), ambiguity, ranking)


def _causes(
    workspace: Workspace, found: Found, before: FloatArray, settings: DiagnosisSettings
) -> list[Cause]:
    """All parts of what was chosen, with sizes, shrink and hidden part."""
    if found.chosen is None:
        return []
    return [
        _cause(
            workspace, found.chosen, index, before, _probabilities(found, index, settings), settings
        )
        for index in range(len(found.alternatives))
    ]


def _probabilities(found: Found, index: int, settings: DiagnosisSettings) -> tuple[Candidate, ...]:
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


def _set(ranking: Sequence[Candidate], settings: DiagnosisSettings) -> tuple[Candidate, ...]:
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


def _exchanged(exchange: Exchange, before: FloatArray) -> Cause:
    """The cause that another wiring is."""
    hypothesis = exchange.hypothesis
    return Cause(
        effect=hypothesis.effect.identifier,
        group=hypothesis.effect.group,
        location=hypothesis.place,
        probability=1.0,
        size={},
        run=None,
        shrink=shrink(exchange.workspace, before, exchange.workspace.explained(None)[0]),
        hidden_cop_mm=0.0,
    )


def _proposed(
    workspace: Workspace, found: Found, answer: _Answer, settings: DiagnosisSettings
) -> NextMotion | None:
    if len(answer.ambiguity) < 2 or not found.alternatives:
        return None
    assert found.chosen is not None
    # What is only just improbable enough comes back once another rival has left.
    confused = {
        (one.effect, one.location): one.probability
        for one in answer.ranking
        if one in answer.ambiguity or one.probability >= RIVAL_FROM
    }
    others = found.chosen.parts[1:]
    rivals = [
        (workspace.scorer.best_form(hypothesis, others, foreseen=True), confused[key])
        for hypothesis, _ in found.alternatives[0]
        if (key := (hypothesis.effect.identifier, hypothesis.place)) in confused
    ]
    return propose(workspace, rivals, settings)
