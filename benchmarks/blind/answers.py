"""The truth of every set: written first, sealed, and opened by the scorer alone."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from blind.layout import PRIVATE, Round
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write

Category = Literal["clean", "single", "double", "unknown"]
CATEGORIES: tuple[Category, ...] = ("clean", "single", "double", "unknown")
PERFECT = "perfect"
"""The reality of a robot that is as its files say."""


@dataclass(frozen=True)
class Place:
    """An effect at a place."""

    effect: str
    location: tuple[str, ...]


@dataclass(frozen=True)
class Truth:
    """An effect that a set has.

    Attributes:
        effect, location: where.
        size: by component, in the component's unit.
        run: in which run of the session it happens; None where it is always there.
        onset: since that run's start, else since the session's [s]; None without.
        strength: its own gap over the floor as it was meant; 0 where it has no size.
        seed: draws its law, whose size follows from the strength; None where the law is the
            simulator's.
    """

    effect: str
    location: tuple[str, ...]
    size: Mapping[str, float]
    run: int | None = None
    onset: float | None = None
    strength: float = 0.0
    seed: int | None = None

    @property
    def place(self) -> Place:
        """Without its size."""
        return Place(self.effect, self.location)


@dataclass(frozen=True)
class Foreign:
    """Something that is not in the library.

    Attributes:
        kind: name in `unknowns` or `unknown_laws`.
        size: in that kind's own unit; 0 where it follows from the strength.
        seed: draws the rest.
        strength: as of a Truth.
    """

    kind: str
    size: float
    seed: int
    strength: float


@dataclass(frozen=True)
class Answer:
    """One set: all that is needed to make it, and what is right to say of it.

    Attributes:
        number: of the set.
        category: what it is for.
        seed: draws robot, cells and noise.
        motions: seed of its motions.
        order: of the thorough set, those that are recorded, in their order.
        pace: how many times as fast as planned.
        imu: whether an inertial unit is recorded.
        base: the reality that its world changes (`world.BASES`).
        world: what it changes, by section.
        truths: effects it has.
        foreign: what it has beside the library.
        built: times that the as-built errors are those of its base.
        slope: of the spectrum of its cells' noise; 0: white.
    """

    number: int
    category: Category
    seed: int
    motions: int
    order: tuple[int, ...]
    pace: float
    imu: bool
    base: str
    world: Mapping[str, Any]
    truths: tuple[Truth, ...] = ()
    foreign: Foreign | None = None
    built: float = 1.0
    slope: float = 0.0

    @property
    def as_built(self) -> bool:
        """Whether its robot has the errors that any robot has."""
        return self.base != PERFECT


def seal(place: Round, answers: Sequence[Answer]) -> str:
    """Write the answers once; their SHA-256, which is also kept in the clear.

    Raises:
        ShoecalError: when the round has other answers already.
    """
    content = json.dumps([dataclasses.asdict(one) for one in answers], indent=1).encode()
    digest = hashlib.sha256(content).hexdigest()
    if place.answers.is_file():
        if check_seal(place) != digest:
            raise ShoecalError(
                f"{place.folder}: holds another round's answers; choose another seed or folder"
            )
        return digest
    place.prepare()
    atomic_write(place.answers, content, PRIVATE & 0o666)
    atomic_write(place.seal, digest + "\n")
    return digest


def check_seal(place: Round) -> str:
    """SHA-256 of the answers, which must be the one written down.

    Raises:
        ShoecalError: where they were changed.
    """
    digest = hashlib.sha256(place.answers.read_bytes()).hexdigest()
    if place.seal.read_text().strip() != digest:
        raise ShoecalError(f"{place.answers}: changed since it was sealed; make a new round")
    return digest


def read_answers(place: Round) -> list[Answer]:
    """The sealed answers, checked against their hash."""
    check_seal(place)
    return [_answer(item) for item in json.loads(place.answers.read_text())]


def _answer(item: dict[str, Any]) -> Answer:
    truths = [Truth(**{**one, "location": tuple(one["location"])}) for one in item["truths"]]
    foreign = None if item["foreign"] is None else Foreign(**item["foreign"])
    changed = {
        "order": tuple(item["order"]),
        "truths": tuple(truths),
        "foreign": foreign,
    }
    return Answer(**{**item, **changed})
