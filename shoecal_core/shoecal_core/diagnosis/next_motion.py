"""The run that would best separate what is confused (Box and Hill, Discrimination among
mechanistic models, 1967).

Rivals A and B, each fitted to the recorded runs with the baseline, foretell a new run as
y_A = X a and y_B = X b. Were A true, the run's log Bayes factor for A would be, in the mean and to
second order,
    1/2 (a - b)' X' (I + X C_B X')^-1 X (a - b)
with X the whitened columns in that run and C_B the covariance of B's fit: what remains when B is
fitted anew to all runs together. Everything follows from the run's Gram matrix X' X.

Such a factor scatters by the root of twice its mean, and counts by a share only (`tempering`): a
run is worth what the true rival's probability gains in the diagnosis that follows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.candidates import BY_HAND, possible_runs
from shoecal_core.diagnosis.forecast import PossibleRun, extended
from shoecal_core.diagnosis.hypotheses import Catalogue, Form, Hypothesis, make_catalogue
from shoecal_core.diagnosis.result import NextMotion
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.tempering import shares, temper
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.regression import Whitening
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import OWN_ERRORS
from shoecal_core.planning.settings import PlannerSettings

FloatArray = NDArray[np.float64]
Rivals = Sequence[tuple[Scored, float]]
Part = tuple[Hypothesis, Form]
_Places = dict[tuple[int, ...], NDArray[np.int64]]

LEAST_CHANCE = 0.5
"""Of taking something out of the set: what has less is not proposed."""
BY_HAND_WORTH = 0.8
"""What a robot can do by itself is preferred from this share of a person's run's worth."""
STANCE_COLUMNS = len(OWN_ERRORS)
"""Columns of the baseline that each stance has for itself."""


@dataclass(frozen=True)
class Separation:
    """What a run is expected to tell.

    Attributes:
        motion: its name.
        gains: (r, r) expected log evidence of each rival, where it is true, over each other one.
        after: (r, r) where each rival is true, the probabilities of all that are foreseen.
        worth: how much of what the true one's probability lacks now the run adds, 0 to 1.
    """

    motion: str
    gains: FloatArray
    after: FloatArray
    worth: float


def propose(
    workspace: Workspace,
    rivals: Rivals,
    settings: DiagnosisSettings,
    planning: PlannerSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> NextMotion | None:
    """Choose it.

    Args:
        workspace: of the recorded runs.
        rivals: fitted explanations that are confused, with their probabilities.
        settings: of the diagnosis. planning: of motions.
        progress: told what is being done and the share done (0 to 1).

    Returns:
        None where nothing is confused, no run on the menu would help, or the robot walked.
    """
    if len(rivals) < 2 or not _stands(workspace.scene):
        return None
    runs = possible_runs(workspace.scene, planning or PlannerSettings(), progress)
    return chosen(separations(workspace, rivals, runs, settings), rivals, settings)


def _stands(scene: Scene) -> bool:
    """Whether it is one of slow runs: a walk is fitted with another baseline than they."""
    return bool(scene.slow_segments) and not scene.fast


def chosen(
    found: Sequence[Separation], rivals: Rivals, settings: DiagnosisSettings
) -> NextMotion | None:
    """The best run; one that needs a person only where it is clearly better."""
    useful = [one for one in found if _chance(one, rivals, settings) >= LEAST_CHANCE]
    alone = [one for one in useful if one.motion not in BY_HAND]
    if not useful:
        return None
    best = max(useful, key=lambda one: one.worth)
    if alone:
        own = max(alone, key=lambda one: one.worth)
        best = own if own.worth >= BY_HAND_WORTH * best.worth else best
    gone = _gone(best.after, settings)
    told = np.flatnonzero((gone | gone.T).any(axis=0)).tolist()
    return NextMotion(best.motion, tuple(rivals[i][0].parts[-1][0].label for i in told))


def _gone(after: FloatArray, settings: DiagnosisSettings) -> NDArray[np.bool_]:
    """(r, r) where each rival is true, which others are too improbable for the set."""
    least = (1.0 - settings.set_share) / settings.set_share
    found: NDArray[np.bool_] = after < least * np.diag(after)[:, None]
    return found


def _chance(one: Separation, rivals: Rivals, settings: DiagnosisSettings) -> float:
    """Probability that a run takes something out of the set that is in it now."""
    now = np.array([probability for _, probability in rivals])
    inside = now >= (1.0 - settings.set_share) * now.max()
    helps = (_gone(one.after, settings) & inside).any(axis=1)
    return float(now @ helps) / float(now.sum())


def separations(
    workspace: Workspace,
    rivals: Rivals,
    runs: Sequence[PossibleRun],
    settings: DiagnosisSettings,
) -> tuple[Separation, ...]:
    """What each possible run would tell of the rivals."""
    recorded = workspace.scene
    if not runs or not _stands(recorded):
        return ()
    scene = extended(recorded, runs)
    shared = len(recorded.baseline) - STANCE_COLUMNS * len(recorded.slow_segments)
    columns, places = _columns(scene, _different(rivals))
    own_precision = workspace.sums.precision[-STANCE_COLUMNS:]
    fits = [_fit(scored, shared, places, len(columns)) for scored, _ in rivals]
    # As in scoring, the noise is as large as what the best rival leaves.
    noise = min(scored.solution.squares for scored, _ in rivals) / workspace.scorer.rows
    whitening = Whitening(scene.samples, scene.mask, workspace.noise)
    scorer = workspace.scorer
    others = scorer.score(rivals[0][0].parts[:-1], foretell=False)
    without = _fit(others, shared, places, len(columns))
    known = max(scored.evidence for scored, _ in rivals) - others.evidence
    now = np.array([probability for _, probability in rivals])
    now /= now.sum()
    found = []
    number = max(workspace.scene.samples.runs)
    for index, run in enumerate(runs, 1):
        gram = _gram(scene, whitening, number + index, shared, columns, own_precision)
        gains = np.array([[expected_gain(one, other, gram) for other in fits] for one in fits])
        told = np.array([expected_gain(one, without, gram) for one in fits])
        after = _after(now, known, gains / noise, told / noise, settings)
        lacks = 1.0 - float(now @ now)
        worth = (float(now @ np.diag(after)) - float(now @ now)) / max(lacks, 1e-300)
        found.append(Separation(run.name, gains / noise, after, worth))
    return tuple(found)


def _after(
    now: FloatArray,
    known: float,
    gains: FloatArray,
    told: FloatArray,
    settings: DiagnosisSettings,
) -> FloatArray:
    """(r, r) probabilities of all rivals after a run, where each is the true one.

    Args:
        now: (r,) before it.
        known: log evidence that the best one has by now. told: (r,) what the run adds.
        gains: (r, r) expected of the run, of which its scatter is taken off.
    """
    before = np.log(now) / temper(known, settings)
    sure = np.maximum(gains - np.sqrt(2.0 * gains), 0.0)
    rows = zip(sure, told, strict=True)
    return np.array([shares(temper(known + more, settings) * (before - row)) for row, more in rows])


@dataclass(frozen=True)
class Fit:
    """A rival's fit to the recorded runs.

    Attributes:
        mean: (q,) of all columns, zero where it has none.
        used: (u,) columns that it has.
        root: (u, u) of their covariance, root @ root.T.
    """

    mean: FloatArray
    used: NDArray[np.int64]
    root: FloatArray


def _fit(scored: Scored, shared: int, places: _Places, count: int) -> Fit:
    solution = scored.solution
    own = len(scored.columns)
    kept = np.concatenate(
        (np.arange(shared), np.arange(len(solution.vector) - own, len(solution.vector)))
    )
    used = np.concatenate(
        [np.arange(shared), *(shared + places[form.columns] for _, form in scored.parts)]
    )
    mean = np.zeros(shared + count)
    mean[used] = solution.vector[kept]
    covariance = solution.covariance[np.ix_(kept, kept)]
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return Fit(mean, used, scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def expected_gain(true: Fit, other: Fit, gram: FloatArray) -> float:
    """Expected log evidence of the true one over the other one, by a run's Gram matrix (q, q)."""
    away = true.mean - other.mean
    seen = gram @ away
    turned = other.root.T @ seen[other.used]
    uncertain = other.root.T @ gram[np.ix_(other.used, other.used)] @ other.root
    refitted = turned @ np.linalg.solve(np.eye(len(turned)) + uncertain, turned)
    return max(0.0, 0.5 * float(away @ seen - refitted))


def _different(rivals: Rivals) -> list[Part]:
    """All parts, each once."""
    return list(
        {form.columns: (hypothesis, form) for one, _ in rivals for hypothesis, form in one.parts}
        .values()
    )  # fmt: skip


def _columns(scene: Scene, parts: Sequence[Part]) -> tuple[FloatArray, _Places]:
    """Columns (k, T, s) of parts in another scene, and where each part's stand.

    A form that another recording would not have, as one that belongs to a moment, adds nothing
    to runs that were not recorded.
    """
    effects = {hypothesis.effect.identifier: hypothesis.effect for hypothesis, _ in parts}
    wanted = {(hypothesis.effect.identifier, hypothesis.place) for hypothesis, _ in parts}
    catalogue = make_catalogue(
        scene, tuple(effects.values()), lambda effect, place: (effect, place) in wanted
    )
    found: list[FloatArray] = []
    places: _Places = {}
    at = 0
    for hypothesis, form in parts:
        there = _same_form(catalogue, hypothesis, form)
        shape = (len(form.columns), *scene.residuals.shape)
        found.append(np.zeros(shape) if there is None else catalogue.columns[list(there.columns)])
        places[form.columns] = np.arange(at, at + len(form.columns))
        at += len(form.columns)
    return np.concatenate(found), places


def _same_form(catalogue: Catalogue, hypothesis: Hypothesis, form: Form) -> Form | None:
    index = next(i for i, one in enumerate(hypothesis.forms) if one is form)
    for other in catalogue.hypotheses:
        if other.label != hypothesis.label:
            continue
        # Where several forms have the same words, they are told by their order.
        ordered = [*other.forms[index : index + 1], *other.forms]
        return next((one for one in ordered if _words(one) == _words(form)), None)
    return None


def _words(form: Form) -> tuple[object, ...]:
    shape = form.shape
    return shape.free, dict(shape.fixed), shape.run


def _gram(
    scene: Scene,
    whitening: Whitening,
    run: int,
    shared: int,
    columns: FloatArray,
    own_precision: FloatArray,
) -> FloatArray:
    """(q, q) products of the shared baseline and of columns in one run.

    What its stances have for themselves has been fitted to them.
    """
    part = scene.samples.run == run
    here = set(np.unique(scene.samples.segment[part]).tolist())
    stances = [index for index, one in enumerate(scene.slow_segments) if one in here]
    own = np.array(
        [shared + STANCE_COLUMNS * stance + i for stance in stances for i in range(STANCE_COLUMNS)]
    )
    whole = np.concatenate((scene.baseline[:shared], columns, scene.baseline[own]))
    flat = whitening(whole)[:, part][:, scene.mask[part]]
    products = flat @ flat.T
    count = shared + len(columns)
    normal = products[count:, count:] + np.diag(np.tile(own_precision, len(stances)))
    across = products[:count, count:]
    gram: FloatArray = products[:count, :count] - across @ np.linalg.solve(normal, across.T)
    return gram
