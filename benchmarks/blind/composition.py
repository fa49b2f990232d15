"""What a round holds: how many sets of each kind, and everything that is drawn of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from blind.answers import PERFECT, Answer, Category, Foreign, Truth
from blind.catalogue import EFFECTS, exactly
from blind.draws import (
    FOREIGN_LIMITS,
    LIMITS,
    STRENGTHS,
    draw_location,
    draw_size,
    magnitude_of,
    unit_key,
)
from blind.laws import LAWS
from blind.noise import STEEPEST
from blind.recorder import HOLD_S, PAUSE_S
from blind.unknown_laws import FUNCTIONS
from blind.unknowns import KINDS
from blind.world import draw_world, over_perfect
from shoecal_core.planning.motion_sets import MOTION_SETS, THOROUGH, UNLOADING

FULL = {"clean": 48, "single": 69, "double": 12, "unknown": 22}
"""Sets of a full round, by category."""
LACKING = 0.1
"""Of the clean sets have no inertial sensor, and as many lack some motions."""
LEAST_PACE = 1.3
"""Motions that show inertia are faster than planned by this at least."""
BUILT = (0.5, 2.5)
"""Between which as-built errors are times those of their base."""
Motions = Mapping[int, Sequence[float]]
_RUNS = MOTION_SETS[THOROUGH].runs
"""What is done where: motion and hint of each."""


@dataclass(frozen=True)
class Mix:
    """How many sets of each category."""

    clean: int
    single: int
    double: int
    unknown: int

    @staticmethod
    def of(total: int | None) -> Mix:
        """The full round, or the same mix of fewer sets, at least one of each."""
        if total is None:
            return Mix(**FULL)
        whole = sum(FULL.values())
        return Mix(**{name: max(1, round(total * part / whole)) for name, part in FULL.items()})


def compose(seed: int, mix: Mix, motions: Motions) -> list[Answer]:
    """All sets of a round in shuffled order: numbers tell nothing.

    Args:
        seed: of the round.
        mix: how many.
        motions: how long each of the thorough set takes [s], by the seed they were planned with.
    """
    rng = np.random.default_rng([seed, 20])
    drawn = [*_clean(mix.clean, rng, motions), *_single(mix.single, rng, motions)]
    drawn += [*_double(mix.double, rng, motions), *_unknown(mix.unknown, rng, motions)]
    return [
        dataclasses.replace(drawn[place], number=number)
        for number, place in enumerate(rng.permutation(len(drawn)), start=1)
    ]


def _blank(category: Category, rng: np.random.Generator, motions: Motions) -> Answer:
    """A set without any effect."""
    base, world = draw_world(rng)
    return Answer(
        number=0,
        category=category,
        seed=int(rng.integers(2**31)),
        motions=int(rng.choice(list(motions))),
        order=tuple(rng.permutation(len(_RUNS)).tolist()),
        pace=1.0,
        imu=True,
        base=base,
        world=world,
        built=float(np.exp(rng.uniform(*np.log(BUILT)))) if base != PERFECT else 1.0,
        slope=float(rng.uniform(0.0, STEEPEST)),
    )


def _clean(count: int, rng: np.random.Generator, motions: Motions) -> Iterator[Answer]:
    for _ in range(count):
        answer, lacking = _blank("clean", rng, motions), rng.uniform()
        if lacking < LACKING:
            answer = dataclasses.replace(answer, imu=False)
        elif lacking < 2.0 * LACKING:
            answer = _without(answer, UNLOADING)
        yield answer


def _single(count: int, rng: np.random.Generator, motions: Motions) -> Iterator[Answer]:
    """Effects in turn, strengths in turn within each."""
    names = rng.permutation(list(EFFECTS))
    for index in range(count):
        turn, place = divmod(index, len(names))
        strength = STRENGTHS[(turn + place) % len(STRENGTHS)]
        answer = _blank("single", rng, motions)
        yield with_effect(answer, str(names[place]), strength, rng, motions[answer.motions])


def _double(count: int, rng: np.random.Generator, motions: Motions) -> Iterator[Answer]:
    made = 0
    while made < count:
        one, other = rng.permutation(list(EFFECTS))[:2]
        answer = _blank("double", rng, motions)
        for name in (str(one), str(other)):
            strength = float(rng.choice(STRENGTHS))
            answer = with_effect(answer, name, strength, rng, motions[answer.motions])
        if _distinct(answer):
            made += 1
            yield answer


def _unknown(count: int, rng: np.random.Generator, motions: Motions) -> Iterator[Answer]:
    names = [*KINDS, *FUNCTIONS]
    for index in range(count):
        turn, place = divmod(index, len(names))
        strength = STRENGTHS[(turn + place) % len(STRENGTHS)]
        answer, kind = _blank("unknown", rng, motions), names[place]
        wanted = over_perfect(answer, strength)
        drawn = kind in FUNCTIONS
        size = 0.0 if drawn else magnitude_of(f"unknown {kind}", wanted, FOREIGN_LIMITS[kind])
        foreign = Foreign(kind, size, int(rng.integers(2**31)), strength)
        yield dataclasses.replace(answer, foreign=foreign)


def with_effect(
    answer: Answer, effect: str, strength: float, rng: np.random.Generator,
    durations: Sequence[float],
) -> Answer:  # fmt: skip
    """One more effect of the table, at a random place."""
    location = draw_location(effect, str(rng.choice(EFFECTS[effect].places)), rng)
    magnitude = 1.0
    if effect in LIMITS:
        wanted = over_perfect(answer, strength)
        magnitude = magnitude_of(unit_key(effect, location), wanted, LIMITS[effect])
    if effect in LAWS:
        truth = Truth(effect, location, {}, strength=strength, seed=int(rng.integers(2**31)))
    else:
        truth = Truth(effect, location, draw_size(effect, magnitude, rng), strength=strength)
    if effect == "slip":
        truth = slipping(answer, truth, rng, durations)
    if effect == "stuck_cell" and rng.uniform() < 0.5:
        onset = float(rng.uniform(0.1, 0.6) * _length(answer, durations))
        truth = dataclasses.replace(truth, size={"time": onset}, onset=onset)
    pace = max(LEAST_PACE, magnitude) if effect == "inertia" else answer.pace
    return dataclasses.replace(answer, truths=(*answer.truths, truth), pace=pace)


def slipping(
    answer: Answer, truth: Truth, rng: np.random.Generator, durations: Sequence[float]
) -> Truth:
    """A foot slips in any run but those in which one hangs in the air."""
    standing = [
        number
        for number, index in enumerate(answer.order, start=1)
        if _RUNS[index][0] not in UNLOADING
    ]
    run = int(rng.choice(standing))
    length = durations[answer.order[run - 1]]
    onset = HOLD_S + float(rng.uniform(0.2, 0.8)) * length
    return dataclasses.replace(truth, run=run, onset=onset, size={**truth.size, "time": onset})


def _without(answer: Answer, motions: Collection[str]) -> Answer:
    """The same with some motions not recorded."""
    kept = tuple(index for index in answer.order if _RUNS[index][0] not in motions)
    return dataclasses.replace(answer, order=kept)


def _length(answer: Answer, durations: Sequence[float]) -> float:
    """Of the session [s], about."""
    return sum(durations[index] + 2.0 * HOLD_S + PAUSE_S for index in answer.order)


def _distinct(answer: Answer) -> bool:
    """Whether its effects differ even for whoever cannot tell exact twins apart."""
    return len({exactly(truth.place) for truth in answer.truths}) == len(answer.truths)
