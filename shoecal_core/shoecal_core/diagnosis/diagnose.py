"""The whole procedure: look, preflight, fit, rank, judge, measure the shrink, propose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from shoecal_core.diagnosis.action import action
from shoecal_core.diagnosis.answer import causes_asked_for, causes_of, confirmed, first_confirmed
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.budget import budget
from shoecal_core.diagnosis.built_worse import answer_as_built
from shoecal_core.diagnosis.dissent import less_probable, worse_runs
from shoecal_core.diagnosis.evidence import evidence
from shoecal_core.diagnosis.measured import MeasuredBefore, at_zeros, measure
from shoecal_core.diagnosis.next_motion import propose
from shoecal_core.diagnosis.preflight import preflight
from shoecal_core.diagnosis.result import Cause, Diagnosis
from shoecal_core.diagnosis.selection import Selection, asked_for
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shaking import shaking
from shoecal_core.diagnosis.shrink import gap, shrink
from shoecal_core.diagnosis.stuck_cell import StuckChannel, stuck_cell
from shoecal_core.diagnosis.swapped_channels import swapped_channels
from shoecal_core.diagnosis.weak_cells import weak_cells
from shoecal_core.diagnosis.where import where
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.progress import Progress, no_progress
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.samples.samples import Samples
from shoecal_core.screening.settings import CalibrationSettings

SHOWN = 20
"""Hypotheses that a ranking lists."""


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
    tolerances: Tolerances | None = None,
    *,
    weight_kg: float | None = None,
    rezero: bool = False,
    without: frozenset[str] = frozenset(),
    only: Callable[[str, Place], bool] | None = None,
    effects: Sequence[Effect] = EFFECTS,
    data: SessionData | None = None,
    progress: Progress = no_progress,
) -> Diagnosis:
    """Find where model and reality differ, and why.

    Args:
        session: recorded.
        train, test: runs; see `split_runs`. Test runs touch no fit; how well the fits predict them
            counts in the ranking, and decides what is named.
        settings: what the user decides.
        tolerances: how far a robot that works may be off its files.
        weight_kg: of robot and shoes, in place of the robot file's [kg].
        rezero: take each run with its own zeros, where a foot hangs in it.
        without: families of signals left out (`signals.FAMILIES`).
        only: whether to look for an effect at a place; None: everywhere (see `Wanted`).
        effects: the library.
        data: of exactly these runs, where it was loaded already, with the same weight.
        progress: see `Progress`.

    Raises:
        ShoecalError: when gaps and parameters cannot be separated in this session at all.
    """
    settings = DiagnosisSettings() if settings is None else settings
    tolerances = Tolerances() if tolerances is None else tolerances
    train, test = split_runs(session, train, test)
    if data is None:
        data = load_data(
            session,
            (*train, *test),
            CalibrationSettings(),
            weight_kg=weight_kg,
            all_readable=False,
            progress=lambda text, share: progress(text, 0.2 * share),
        )
    samples = data.whole_samples(settings)
    zeros = tuple(zero for zero in data.zeros if zero.run in samples.runs)
    train, test = (tuple(run for run in runs if run in samples.runs) for runs in (train, test))
    if rezero:
        samples = at_zeros(samples, zeros, train)
    progress("fitting with nothing added", 0.2)
    wanted = only or (lambda _effect, _place: True)

    def laid_out(whole: Samples) -> Workspace:
        first = make_signal_model(whole, first_parameters(whole, train), settings, without)
        return make_workspace(first, effects, train, test, settings, tolerances, wanted)

    workspace = laid_out(samples)
    stuck = _stuck_cell(workspace, wanted)
    looked_at = workspace.catalogue.hypotheses or workspace.catalogue.swapped or stuck
    if only is not None and not looked_at:
        raise SessionError(
            session.folder,
            "nothing of what was asked for can be looked at: there is no such place in this robot "
            "and these shoes, or the recording lacks what the effect needs",
        )
    progress("checking what is identifiable", 0.45)
    known = MeasuredBefore()
    if only is None:
        known = measure(
            data, samples, () if rezero else zeros, train,
            workspace.signal_model.parameters, settings, weighs=weight_kg is None,
        )  # fmt: skip
    corrected = laid_out(known.corrected(samples)) if known else workspace
    if stuck is not None:
        answering = laid_out(stuck.corrected(known.corrected(samples)))
        kept = stuck.explains(corrected, answering)
        corrected, stuck = (answering, stuck) if kept else (corrected, None)
    before = preflight(corrected, settings)
    progress("trying every effect", 0.5)
    swap = swapped_channels(corrected, effects, settings, wanted)
    best = corrected if swap is None else swap.workspace
    found, named, denied = _found(best, settings, asked=only is not None)
    progress("measuring the shrink", 0.8)
    searched = best
    best = searched.at(named.stands(searched.scorer, settings))
    certain = [
        *(known.causes(workspace, corrected, settings) if known else ()),
        *(() if stuck is None else (stuck.cause(workspace, corrected),)),
        *(() if swap is None else (swap.cause(corrected.explained(None)[0]),)),
        *weak_cells(best, wanted),
    ]
    best, said, built = answer_as_built(searched, certain, named, settings)
    if only is not None and not certain:
        # For who asks how an effect would do, though nothing may confirm it.
        said = replace(said, causes=_asked(searched, found, settings, named=bool(said.causes)))
    progress("done", 1.0)
    chosen = found.chosen if said.causes else None
    corrected_gap = best.explained(None)[0]
    without_any = workspace.explained(None)[0] if certain else corrected_gap
    left = best.explained(chosen)[0]
    worse, grown = worse_runs(best, without_any, left, settings)
    diagnosis = Diagnosis(
        verdict=said.verdict,
        gap=gap(best, without_any),
        where=where(best, without_any, chosen),
        shrink=shrink(best, without_any, left) if said.causes else None,
        causes=said.causes,
        ambiguity=said.ambiguity,
        ranking=said.ranking[:SHOWN],
        cannot_detect=(*before.cannot_detect, *_lacking(effects, best, only)),
        cannot_separate=before.cannot_separate,
        next_motion=propose(said.ambiguity),
        train=train,
        test=test,
        notes=(*samples.notes, *shaking(best.signal_model), *built),
        robot=samples.robot.name,
        shoe=samples.shoe.name,
        evidence=evidence(best, chosen, [one.scored for one in found.singles]),
        dissent=(*denied, *grown),
        zeros=zeros,
        budget=budget(best, corrected_gap, chosen),
    )
    diagnosis = less_probable(diagnosis, worse) if said.causes else diagnosis
    return replace(diagnosis, action=action(diagnosis))


def _found(
    best: Workspace, settings: DiagnosisSettings, *, asked: bool
) -> tuple[Selection, Selection, tuple[str, ...]]:
    """What is shown, what of it is named, and in words what is not."""
    if not asked:
        named, denied = first_confirmed(best, settings)
        return named, named, denied
    shown = asked_for(best)
    named, denied = confirmed(best, shown, settings)
    # What was not needed is no evidence that anything is there.
    return shown, replace(named, unmodelled=shown.unmodelled), denied


def _asked(
    workspace: Workspace, found: Selection, settings: DiagnosisSettings, *, named: bool
) -> tuple[Cause, ...]:
    """The best of what somebody asked for where it is named, else all of it, each by itself."""
    if not named:
        return tuple(causes_asked_for(workspace, found))
    return tuple(causes_of(workspace.at(found.stands(workspace.scorer, settings)), found))


def _lacking(
    effects: Sequence[Effect], workspace: Workspace, only: Callable[[str, Place], bool] | None
) -> Iterator[str]:
    """Lines for effects that somebody asked for and that this recording cannot show."""
    if only is None:
        return
    for effect in effects:
        if effect.identifier in workspace.catalogue.lacking and only(effect.identifier, ()):
            yield f"{effect.identifier}: there is nothing in this recording to see it by"


def _stuck_cell(workspace: Workspace, wanted: Callable[[str, Place], bool]) -> StuckChannel | None:
    """The cell that got stuck, if one did and it is looked for."""
    samples = workspace.signal_model.samples
    found = stuck_cell(samples)
    if found is None or not wanted("stuck_cell", (samples.shoe.names[found.channel],)):
        return None
    return found
