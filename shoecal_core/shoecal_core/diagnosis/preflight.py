"""What is identifiable in a session: which effects it would not show, and which look alike.

Columns are taken after the baseline has explained what it can of them: with the Gram matrix of the
whitened columns in blocks of the baseline b and of hypotheses h, what is left is its Schur
complement S = G_hh - G_hb (G_bb + P)^-1 G_bh, P the baseline's prior precision. An effect of size s
is then expected to gain s' S s / 2 in log evidence (Lindley, On a measure of the information
provided by an experiment, 1956, for linear models), less what its prior costs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.tempering import needed
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signals import COP
from shoecal_core.shoe.shoe import FEET

MATTERS_M = 0.001
"""Mean change of the CoP from which any effect matters."""
SEPARATE_FROM = 3.0
"""Expected log evidence of one explanation over another from which they can be separated."""

LARGE = 3.0
"""Times its prior: so large another explanation may be without it being held against it."""


@dataclass(frozen=True)
class Preflight:
    """What cannot be seen, and what cannot be separated.

    Attributes:
        cannot_detect: effects that would not show at a size that matters, in words.
        cannot_separate: sets of labels of which the session takes one for another.
    """

    cannot_detect: tuple[str, ...]
    cannot_separate: tuple[tuple[str, ...], ...]


def preflight(workspace: Workspace, settings: DiagnosisSettings) -> Preflight:
    """Say what the training runs of a session could show of each hypothesis."""
    hypotheses = workspace.catalogue.hypotheses
    left = unexplained(workspace)
    sizes = typical_sizes(workspace)
    gains = np.array([_gain(one, left, sizes) for one in hypotheses])
    seen = gains >= needed(settings)
    shown = [hypotheses[index] for index in np.flatnonzero(seen)]
    return Preflight(
        cannot_detect=(*_missing_channels(workspace), *_unseen(workspace, seen)),
        cannot_separate=_alike(shown, left, sizes),
    )


def unexplained(workspace: Workspace) -> FloatArray:
    """(k, k) products of the hypotheses' columns that the baseline leaves, on training runs."""
    sums = workspace.sums
    products = sums.products
    base, count = sums.base, len(workspace.catalogue.columns)
    posterior = Posterior(products[:base, :base], sums.precision)
    shared = posterior.whiten(products[:base, base : base + count])
    left: FloatArray = products[base : base + count, base : base + count] - shared.T @ shared
    return left


def typical_sizes(workspace: Workspace) -> FloatArray:
    """(k,) of each column: its prior's, or what moves the CoP by MATTERS_M where that is less."""
    columns = workspace.catalogue.columns
    part = workspace.rows_of(workspace.train)
    moved = np.linalg.norm(columns[:, part, COP], axis=2).mean(axis=1)
    sizes = np.zeros(len(columns))
    for hypothesis in workspace.catalogue.hypotheses:
        for form in hypothesis.forms:
            own = list(form.columns)
            sizes[own] = np.minimum(form.std, MATTERS_M / np.maximum(moved[own], 1e-12))
    return sizes


def _gain(hypothesis: Hypothesis, left: FloatArray, sizes: FloatArray) -> float:
    """Expected log evidence of its best seen component, in a usual form."""
    gains = []
    for form in hypothesis.forms:
        own = list(form.columns)
        block = left[np.ix_(own, own)]
        prior = 2.0 * Posterior(block, form.std**-2.0).half_log_volume
        gains.append(0.5 * float(np.max(sizes[own] ** 2 * np.diag(block)) - prior))
    return float(np.median(gains))


# What cannot be seen


def _missing_channels(workspace: Workspace) -> list[str]:
    """Lines for effects that need what was not recorded."""
    samples = workspace.signal_model.samples
    tracks, lines = samples.tracks, list[str]()
    if all(track.temperature is None for track in tracks):
        lines.append("drifts with temperature: none was recorded, only drifts over time are found")
    if samples.efforts is None:
        lines.append("off_axis_load: joint efforts were not recorded")
    if any(track.up is None for track in tracks):
        lines.append("floor_tilt apart from joint offsets and shifted masses: no /imu")
    return lines


def _unseen(workspace: Workspace, seen: BoolArray) -> list[str]:
    """One line an effect and foot, with how many of its places are concerned."""
    places: defaultdict[tuple[str, str], list[tuple[Hypothesis, bool]]] = defaultdict(list)
    for hypothesis, is_seen in zip(workspace.catalogue.hypotheses, seen, strict=True):
        key = hypothesis.effect.identifier, _whereabouts(hypothesis)
        places[key].append((hypothesis, bool(is_seen)))
    lines = []
    for (effect, where), group in places.items():
        hidden = [hypothesis for hypothesis, is_seen in group if not is_seen]
        if not hidden:
            continue
        if len(group) == 1:
            lines.append(hidden[0].label)
            continue
        count = f"{len(hidden)} of {len(group)} places"
        shown = [hypothesis for hypothesis, is_seen in group if is_seen]
        if len(hidden) <= len(shown):
            count += f": {_places(hidden)}"
        elif shown:
            count += f": all but {_places(shown)}"
        lines.append(f"{effect}{where} ({count})")
    return lines


def _places(hypotheses: Sequence[Hypothesis]) -> str:
    return ", ".join(" and ".join(one.place) for one in hypotheses)


def _whereabouts(hypothesis: Hypothesis) -> str:
    """Words for what its places have in common; empty for joints and links."""
    place = hypothesis.place
    foot, _, cell = place[0].partition("/") if place else ("", "", "")
    if cell and foot in FEET:
        cells = "between cells" if len(place) > 1 else "of cells"
        return f" {cells} of the {foot} foot"
    return " of whole feet" if place and place[0] in FEET else ""


# What looks alike


def distances(hypotheses: Sequence[Hypothesis], left: FloatArray, sizes: FloatArray) -> FloatArray:
    """(h, h) expected log evidence of each hypothesis, where it is true, over each other one.

    Each in its usual form and size, all components together; the other one in the form that
    comes nearest, and up to LARGE times as large as usual.
    """
    truth = np.zeros((len(hypotheses), len(left)))
    for row, hypothesis in zip(truth, hypotheses, strict=True):
        own = list(hypothesis.usual.columns)
        row[own] = sizes[own]
    seen = left @ truth.T
    whole = np.einsum("hk,kh->h", truth, seen)
    found = np.zeros((len(hypotheses), len(hypotheses)))
    for index, other in enumerate(hypotheses):
        most = np.zeros(len(hypotheses))
        for form in other.forms:
            own = list(form.columns)
            nearest = Posterior(left[np.ix_(own, own)], (LARGE * form.std) ** -2.0)
            most = np.maximum(most, (nearest.whiten(seen[own]) ** 2).sum(axis=0))
        found[:, index] = 0.5 * (whole - most)
    np.fill_diagonal(found, 0.0)
    return np.maximum(found, 0.0)


def _alike(
    hypotheses: Sequence[Hypothesis], left: FloatArray, sizes: FloatArray
) -> tuple[tuple[str, ...], ...]:
    """Sets of labels each of which is taken for any other of its set, or the other for it."""
    if not hypotheses:
        return ()
    close = distances(hypotheses, left, sizes) < SEPARATE_FROM
    close |= close.T
    np.fill_diagonal(close, False)
    neighbours = [frozenset(np.flatnonzero(row).tolist()) for row in close]
    concerned = frozenset(index for index, others in enumerate(neighbours) if others)
    cliques = list(_cliques(neighbours, frozenset(), concerned, frozenset())) if concerned else []
    sets = sorted(sorted(one) for one in _covering(cliques))
    return tuple(tuple(hypotheses[index].label for index in one) for one in sets)


def _covering(cliques: Sequence[frozenset[int]]) -> Iterator[frozenset[int]]:
    """The largest ones, as many as it takes to hold every pair."""
    covered: set[tuple[int, int]] = set()
    for clique in sorted(cliques, key=lambda one: (-len(one), sorted(one))):
        pairs = set(combinations(sorted(clique), 2))
        if pairs - covered:
            covered |= pairs
            yield clique


def _cliques(
    neighbours: Sequence[frozenset[int]],
    chosen: frozenset[int],
    open_: frozenset[int],
    done: frozenset[int],
) -> Iterator[frozenset[int]]:
    """Largest sets that are all neighbours of each other (Bron and Kerbosch, 1973, pivoting)."""
    if not open_ and not done:
        yield chosen
        return
    pivot = max(open_ | done, key=lambda index: len(open_ & neighbours[index]))
    for index in sorted(open_ - neighbours[pivot]):
        near = neighbours[index]
        yield from _cliques(neighbours, chosen | {index}, open_ & near, done & near)
        open_, done = open_ - {index}, done | {index}
