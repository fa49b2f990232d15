"""What an effect is to a diagnosis: where it can sit, and what it adds to the signals.

An effect is one small class. To add one, write it in a file of your own that defines
`EFFECTS = (MyEffect(), ...)` and name the file to `shoecal diagnose --effects-from`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Protocol

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.deviation import FORM, Deviation
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.shoe.priors import USUAL_WEIGHT

ALL = "all"
Place = tuple[str, ...]
FORCES = {
    "kg": 1, "N": 1, "N/s": 1, "N/K": 1, "1/N": -1, "1/N^2": -2, "rad/(N m)": -1,
}  # fmt: skip
"""Powers of a force in the units of components."""
LEAST_FACTOR = 0.2
AT = " at "


@dataclass(frozen=True)
class Component:
    """One number of an effect's size.

    Attributes:
        name, unit: as in the files.
        std: how large it usually is where it is: the prior, in its unit, on a robot of
            `USUAL_WEIGHT`; units with forces in them grow with the robot.
        least: below this it makes no sense.
        form: how much more than others it hangs on the form that reality has it in (times FORM).
        blur: least uncertainty in any session: a standard deviation in its unit.
        most: what is larger, either way, is not this effect; by default nothing is.
        as_built: setting of `Tolerances` that says how far a robot that works may be off; empty
            for what is normally not there at all.
    """

    name: str
    unit: str
    std: float
    least: float = -np.inf
    form: float = 1.0
    blur: float = 0.0
    most: float | None = None
    as_built: str = ""


@dataclass(frozen=True)
class Shape:
    """One form of an effect at a place: what each unit of its free components adds.

    Attributes:
        free: names of the components that are fitted; see `one_of`.
        columns: (len(free), T, s) signals a unit.
        fixed: components that this form holds at a value.
        run: the run that it happens in; None: in all.
        onset: when it starts there [s]; None: always there.
        signal_model: that it belongs to, where it changes what channels mean; None: the one that
            was given.
        scale: a component's value is the fitted number times this (1 where not listed).
        within: least and most of a component for which this form holds, where not for all.
    """

    free: tuple[str, ...]
    columns: FloatArray
    fixed: Mapping[str, float] = field(default_factory=dict)
    run: int | None = None
    onset: float | None = None
    signal_model: SignalModel | None = None
    scale: Mapping[str, float] = field(default_factory=dict)
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)


class Effect(Protocol):
    """A cause of a gap; its first three members are mostly attributes of the class."""

    @property
    def identifier(self) -> str:
        """Its name, part of the public contract."""
        ...

    @property
    def group(self) -> str:
        """Its class: load_cell, timing, body, contact or dynamics."""
        ...

    @property
    def components(self) -> tuple[Component, ...]:
        """Of its size, each with its prior."""
        ...

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Where it can sit in this robot and these shoes."""
        ...

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Its forms at a place; none where the recording lacks what it needs."""
        ...


def one_of(component: str, channel: str) -> str:
    """Name of a component that channels of one place have each for itself: `rate left/heel`."""
    return f"{component} {channel}"


def one_at(component: str, where: str) -> str:
    """Name of a component that a law has for itself at each of some loads or times: `bend at 9 N`.

    The simulator has laws with a formula alone, and none of these.
    """
    return f"{component}{AT}{where}"


def has_formula(names: Iterable[str]) -> bool:
    """Whether a law with these components is one that a formula gives."""
    return not any(AT in name for name in names)


def split_name(name: str) -> tuple[str, str]:
    """Component, and the channel that it is of; empty where all have it alike."""
    component, _, channel = name.partition(" ")
    return component, channel


def as_built_std(component: Component, tolerances: Tolerances, weight: float) -> float:
    """Of one component on a robot of this weight [N], in the component's unit."""
    if not component.as_built:
        return 0.0
    std = float(getattr(tolerances, component.as_built))
    return std * (weight / USUAL_WEIGHT) ** FORCES.get(component.unit, 0)


def deviations(
    effect: Effect,
    signal_model: SignalModel,
    tolerances: Tolerances,
    places: Iterable[Place],
    *,
    forms: int = 1,
) -> Iterator[Deviation]:
    """Every as-built component of an effect at these places, in each of its first forms."""
    weight = signal_model.samples.robot.weight
    stds = {one.name: as_built_std(one, tolerances, weight) for one in effect.components}
    known = {one.name: one for one in effect.components}
    for place in places:
        shapes = list(islice(effect.shapes(signal_model, place), forms))
        for shape in shapes:
            for name, column in zip(shape.free, shape.columns, strict=True):
                if stds.get(name, 0.0) > 0.0:
                    one = known[name]
                    yield Deviation(
                        effect.identifier, place, name, one.unit,
                        stds[name] / np.sqrt(len(shapes)), column, form=FORM * one.form,
                    )  # fmt: skip


def lower_bounds(effect: Effect, shape: Shape) -> FloatArray:
    """(k,) least values of a shape's k components; LEAST_FACTOR for a factor that is no component.

    Such a factor says how much of the effect's own fixed form is there.
    """
    known = {component.name: component.least for component in effect.components}
    known |= {name: least for name, (least, _) in shape.within.items()}
    return np.array([known.get(split_name(name)[0], LEAST_FACTOR) for name in shape.free])


def stds(effect: Effect, names: tuple[str, ...], weight: float) -> FloatArray:
    """(k,) priors of k components on a robot of this weight [N]; 1 for what is no component."""
    known = {
        component.name: component.std * (weight / USUAL_WEIGHT) ** FORCES.get(component.unit, 0)
        for component in effect.components
    }
    return np.array([known.get(split_name(name)[0], 1.0) for name in names])


def upper_bounds(effect: Effect, shape: Shape, weight: float) -> FloatArray:
    """(k,) largest values of a shape's k components; infinite for what is no component.

    Args:
        weight: of the robot [N], with which units with forces in them grow.
    """
    known = {
        one.name: np.inf
        if one.most is None
        else one.most * (weight / USUAL_WEIGHT) ** FORCES.get(one.unit, 0)
        for one in effect.components
    }
    known |= {name: most for name, (_, most) in shape.within.items()}
    return np.array([known.get(split_name(name)[0], np.inf) for name in shape.free])
