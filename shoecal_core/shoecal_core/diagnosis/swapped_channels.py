"""Hypotheses that change what channels mean: they cannot be added, so the fit is repeated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.result import Cause
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import shrink
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.wiring import Wiring
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    at_cop,
    by_parameters,
    combined,
    weight_below,
)

CLEARLY = 0.5
"""Squares that another wiring must leave, over those of the shoe file's."""
LEVER = 0.04
"""m; by which moments count against forces."""


@dataclass(frozen=True)
class Swap:
    """A wiring that explains much more than the shoe file's.

    Attributes:
        hypothesis: which.
        workspace: of the session under it.
    """

    hypothesis: Hypothesis
    workspace: Workspace

    def cause(self, before: FloatArray) -> Cause:
        """What it is, by residuals (T, s) under the shoe file's wiring."""
        return Cause(
            effect=self.hypothesis.effect.identifier,
            group=self.hypothesis.effect.group,
            location=self.hypothesis.place,
            probability=1.0,
            size={},
            run=None,
            shrink=shrink(self.workspace, before, self.workspace.explained(None)[0]),
            hidden_cop_mm=0.0,
        )


def swapped_channels(
    workspace: Workspace,
    effects: Sequence[Effect],
    settings: DiagnosisSettings,
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
) -> Swap | None:
    """The best other wiring, where it is clearly better; all else is then looked for under it.

    Wrenches are linear in gains and offsets whatever the wiring, so a quick look is one linear
    least squares each; the best is then fitted in full.
    """
    if not workspace.catalogue.swapped:
        return None
    usual = _misfits(workspace, workspace.signal_model.wiring)
    found = []
    for hypothesis in workspace.catalogue.swapped:
        signal_model = hypothesis.forms[0].shape.signal_model
        assert signal_model is not None
        found.append((_misfits(workspace, signal_model.wiring), hypothesis, signal_model))
    misfits, hypothesis, signal_model = min(found, key=lambda one: one[0])
    if any(now > CLEARLY * before for now, before in zip(misfits, usual, strict=True)):
        return None
    # Gains and offsets of the file's wiring are far from these, and priors are about the start.
    start = first_parameters(signal_model.samples, workspace.train)
    parameters = _nearest(workspace, signal_model.wiring, start)
    return Swap(
        hypothesis,
        make_workspace(
            signal_model.with_parameters(parameters),
            effects,
            workspace.train,
            workspace.test,
            settings,
            workspace.tolerances,
            wanted,
        ),
    )


def _nearest(workspace: Workspace, wiring: Wiring, start: ChannelParameters) -> ChannelParameters:
    """Gains and offsets that are best on the training runs, of these the nearest to a start."""
    matrix, target = _wrenches(workspace, wiring, workspace.train)
    first = np.concatenate((start.gain, start.offset))
    gain, offset = np.split(first + _solved(matrix, target - matrix @ first), 2)
    return ChannelParameters(gain, offset)


def _solved(matrix: FloatArray, target: FloatArray) -> FloatArray:
    """(p,) least squares, of all such the smallest by the columns' lengths."""
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-12)
    found: FloatArray = np.linalg.lstsq(matrix / size, target, rcond=1e-6)[0] / size
    return found


def _misfits(workspace: Workspace, wiring: Wiring) -> tuple[float, ...]:
    """Mean squares [N^2] of what is left of the wrenches of both feet by the gains and offsets that
    are best on the training runs: on these, and on the test runs if there are any.
    """
    matrix, target = _wrenches(workspace, wiring, workspace.train)
    fitted = _solved(matrix, target)
    sets = [(matrix, target), _wrenches(workspace, wiring, workspace.test)]
    return tuple(float(np.mean((b - a @ fitted) ** 2)) for a, b in sets if len(b))


def _wrenches(
    workspace: Workspace, wiring: Wiring, runs: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """(R, p) of gains and offsets, and (R,) expected, of both feet's wrenches on some runs."""
    signal_model: SignalModel = workspace.signal_model
    samples = signal_model.samples
    base = weight_below(samples.shoe)
    scale = np.array([1.0, 1.0 / LEVER, 1.0 / LEVER])
    count = 2 * len(wiring.foot)
    rows, targets = [np.zeros((0, 3, count))], [np.zeros((0, 3))]
    wanted = samples.both & workspace.rows_of(runs)
    for segment, support in enumerate(signal_model.supports):
        part = wanted & (samples.segment == segment)
        if not part.any():
            continue
        columns = wiring.in_left(support)
        wrench = at_cop(samples.force[part], samples.cop[part]) - combined(base, support)
        rows.append(by_parameters(scale[:, None] * columns.T, samples.readings[part]))
        targets.append(scale * wrench)
    return np.concatenate(rows).reshape(-1, count), np.concatenate(targets).ravel()
