"""Settings as data: frozen dataclasses whose fields know their unit, bounds and meaning.

One declaration serves three readers: Python code, a ROS parameter file and the ROS nodes,
which declare one parameter a field.

    @dataclass(frozen=True)
    class DriverSettings(Settings):
        rate: float = setting(80.0, "Hz", "samples a second", minimum=1.0)
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TypeVar, cast, get_type_hints

from shoecal_core.errors import ShoecalError

Value = bool | int | float | str
T = TypeVar("T", bound=Value)
S = TypeVar("S", bound="Settings")

LARGEST_INT = 2**63
"""What ROS parameters can hold; far larger ones are no floats either."""
_META = "shoecal"
_KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}


class SettingError(ShoecalError):
    """A setting that cannot be used.

    Attributes:
        key: name of the setting.
        problem: what is wrong with it and what would be right.
    """

    def __init__(self, key: str, problem: str) -> None:
        self.key = key
        self.problem = problem
        super().__init__(f"{key}: {problem}")


@dataclass(frozen=True)
class Setting:
    """What is known of one field.

    Attributes:
        name: of the field, and of the ROS parameter.
        kind: bool, int, float or str.
        default: value where nothing is configured.
        unit: for example `m` or `1/rad^2`; empty where there is none.
        doc: what it does.
        minimum, maximum: bounds, both allowed themselves; infinite where there is none.
        choices: the only texts allowed; empty where any is.
    """

    name: str
    kind: type[Value]
    default: Value
    unit: str
    doc: str
    minimum: float
    maximum: float
    choices: tuple[str, ...]

    def checked(self, value: object) -> Value:
        """The value in this setting's type.

        Raises:
            SettingError: for another type, a value out of bounds, or one that is not finite.
        """
        if isinstance(value, int) and abs(value) > LARGEST_INT:
            raise SettingError(self.name, "number too large")
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        # bool is an int in Python, hence the comparison of exact types.
        if type(value) is not self.kind or not isinstance(value, bool | int | float | str):
            raise SettingError(self.name, f"expected {_KINDS[self.kind]}, got {value!r}")
        if isinstance(value, str):
            if self.choices and value not in self.choices:
                raise SettingError(self.name, f"'{value}' is not one of: {', '.join(self.choices)}")
        elif not isinstance(value, bool):
            self._check_bounds(value)
        return value

    def _check_bounds(self, value: float) -> None:
        if not math.isfinite(value):
            raise SettingError(self.name, f"expected a finite number, got {value}")
        if not self.minimum <= value <= self.maximum:
            low = f"at least {self.minimum:g}" if self.minimum > -math.inf else ""
            high = f"at most {self.maximum:g}" if self.maximum < math.inf else ""
            bounds = " and ".join(filter(None, (low, high)))
            unit = f" {self.unit}" if self.unit else ""
            raise SettingError(self.name, f"must be {bounds}{unit}, got {value:g}{unit}")


def setting(
    default: T,
    unit: str,
    doc: str,
    *,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    choices: Collection[str] = (),
) -> T:
    """A field of a Settings class; see Setting for the arguments."""
    metadata = {_META: (unit, doc, minimum, maximum, tuple(choices))}
    return dataclasses.field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Settings:
    """Base of all settings: holding one means that every value is within its bounds."""

    def __post_init__(self) -> None:
        for entry in describe(type(self)):
            value = entry.checked(getattr(self, entry.name))
            object.__setattr__(self, entry.name, value)


def describe(cls: type[Settings]) -> tuple[Setting, ...]:
    """Every field of a Settings class, in the order of declaration."""
    kinds = get_type_hints(cls)
    entries = []
    for field in dataclasses.fields(cls):
        unit, doc, minimum, maximum, choices = field.metadata[_META]
        entries.append(
            Setting(
                name=field.name,
                kind=kinds[field.name],
                default=cast(Value, field.default),
                unit=unit,
                doc=doc,
                minimum=minimum,
                maximum=maximum,
                choices=choices,
            )
        )
    return tuple(entries)


def from_values(cls: type[S], values: Mapping[str, object]) -> S:
    """Settings from named values; the rest are defaults.

    Raises:
        SettingError: for an unknown name, a wrong type or a value out of bounds.
    """
    known = {entry.name: entry for entry in describe(cls)}
    for name in values:
        if name not in known:
            raise SettingError(name, f"unknown key; known: {', '.join(known)}")
    return cls(**{name: known[name].checked(value) for name, value in values.items()})
