"""Everything that could be the cause, each with the columns of its forms."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.result import NamedHypothesis
from shoecal_core.error_sources.base import Effect, Place, Shape, lower_bounds, stds, upper_bounds
from shoecal_core.error_sources.signal_model import SignalModel


@dataclass(frozen=True)
class Form:
    """One shape of a hypothesis, and where its columns stand.

    Attributes:
        shape: what it is.
        columns: places among all hypotheses' columns.
        std: (k,) priors of its free components.
        least, most: (k,) between which they make sense, `most` either way.
    """

    shape: Shape
    columns: tuple[int, ...]
    std: FloatArray
    least: FloatArray
    most: FloatArray


@dataclass(frozen=True)
class Hypothesis:
    """An effect at a place.

    Attributes:
        effect, place: which and where.
        forms: at least one.
        prior: its share of what is believed beforehand of all hypotheses.
    """

    effect: Effect
    place: Place
    forms: tuple[Form, ...]
    prior: float

    @property
    def usual(self) -> Form:
        """The form in the middle."""
        return self.forms[len(self.forms) // 2]

    @property
    def label(self) -> str:
        """For a person to read."""
        return NamedHypothesis(self.effect.identifier, self.place, 0.0).label


@dataclass(frozen=True)
class Catalogue:
    """All hypotheses of a signal model.

    Attributes:
        hypotheses: those whose columns stand in `columns`.
        swapped: those that change what channels mean; each has a signal model of its own.
        columns: (k, T, s).
        lacking: identifiers of effects for which the recording has nothing to offer.
    """

    hypotheses: tuple[Hypothesis, ...]
    swapped: tuple[Hypothesis, ...]
    columns: FloatArray
    lacking: tuple[str, ...]


def make_catalogue(
    signal_model: SignalModel,
    effects: Sequence[Effect],
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
) -> Catalogue:
    """Lay out every form of every effect at every place.

    Every class has the same prior, within it every effect, within that every place.
    """
    groups = {effect.group for effect in effects}
    weight = signal_model.samples.robot.weight
    found: list[tuple[Effect, Place, list[Shape]]] = []
    lacking = []
    for effect in effects:
        before = len(found)
        for place in effect.places(signal_model):
            if not wanted(effect.identifier, place):
                continue
            shapes = list(effect.shapes(signal_model, place))
            if shapes:
                found.append((effect, place, shapes))
        if len(found) == before:
            lacking.append(effect.identifier)
    columns: list[FloatArray] = []
    at = 0
    ordinary: list[Hypothesis] = []
    swapped: list[Hypothesis] = []
    for effect, place, shapes in found:
        forms = []
        for shape in shapes:
            count = len(shape.columns)
            places = tuple(range(at, at + count)) if shape.signal_model is None else ()
            forms.append(
                Form(
                    shape,
                    places,
                    std=stds(effect, shape.free, weight),
                    least=lower_bounds(effect, shape),
                    most=upper_bounds(effect, shape, weight),
                )
            )
            if shape.signal_model is None:
                columns.append(shape.columns)
                at += count
        hypothesis = Hypothesis(effect, place, tuple(forms), _prior(effect, found, effects, groups))
        (swapped if shapes[0].signal_model is not None else ordinary).append(hypothesis)
    whole = np.concatenate(columns) if columns else np.zeros((0, *signal_model.residuals.shape))
    return Catalogue(tuple(ordinary), tuple(swapped), whole, tuple(lacking))


def _prior(
    effect: Effect,
    found: Iterable[tuple[Effect, Place, list[Shape]]],
    effects: Sequence[Effect],
    groups: set[str],
) -> float:
    alike = sum(1 for one in effects if one.group == effect.group)
    places = sum(1 for other, _, _ in found if other is effect)
    return 1.0 / (len(groups) * alike * places)
