"""How large each effect must be to make a gap: measured once, kept in unit_sizes.json.

    .venv/bin/python benchmarks/blind_check.py unit-sizes [--jobs 2]

One set of motions and one world; each effect alone, at a guess and then nearer and nearer to the
magnitude that makes three times the floor's gap. `draws.magnitude_of` reads between and beyond.
"""

from __future__ import annotations

import dataclasses
import json
import tempfile
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np

from blind.answers import PERFECT, Answer, Foreign, Truth
from blind.catalogue import EFFECTS
from blind.composition import slipping
from blind.draws import (
    AIM,
    CARRIERS,
    FIRST_GUESS,
    FOREIGN_GUESS,
    FOREIGN_LIMITS,
    JOINTS,
    LIMITS,
    LINKS,
    UNKNOWN,
    draw_location,
    draw_size,
    own_gap,
    unit_key,
)
from blind.gap import MeasuredGap, measure_gap
from blind.generate import make_set
from blind.layout import UNIT_SIZES, Round
from blind.motions import planned_set
from blind.processes import over
from blind.world import middle_world
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.recording.session import Session

_TRIES, _NEAR = 3, 0.35
"""Magnitudes tried of each, and how near to the aim, as a logarithm, is near enough."""
_RATE_HZ = 25.0
"""Enough for a mean error, and four times as fast to write."""
_SEED = 1
_ORDER = (0, 1, 2, 6)
"""Of the thorough set: three motions to train, one to test; all of them tell much the same."""


@dataclasses.dataclass(frozen=True)
class Unit:
    """What is measured: an effect at a place, or something that is not in the table."""

    key: str
    effect: str
    location: tuple[str, ...] = ()

    @property
    def guess(self) -> float:
        """Magnitude to begin with."""
        return FIRST_GUESS[self.effect] if self.effect else FOREIGN_GUESS[self.kind]

    @property
    def limit(self) -> float:
        """Largest magnitude."""
        return LIMITS[self.effect] if self.effect else FOREIGN_LIMITS[self.kind]

    @property
    def kind(self) -> str:
        """Of what is not in the table."""
        return self.key.removeprefix(UNKNOWN)


def units() -> list[Unit]:
    """Everything that has a magnitude."""
    found: dict[str, Unit] = {}
    for effect, location in _places():
        key = unit_key(effect, location)
        found.setdefault(key, Unit(key, effect, location))
    foreign = [Unit(f"{UNKNOWN}{kind}", "") for kind in FOREIGN_GUESS]
    return [*found.values(), *foreign]


def _places() -> Iterator[tuple[str, tuple[str, ...]]]:
    for effect in LIMITS:
        for kind in EFFECTS[effect].places:
            if kind == "joint":
                yield from ((effect, (joint,)) for joint in JOINTS)
            elif kind == "link":
                links = CARRIERS if effect == "payload" else LINKS
                yield from ((effect, (link,)) for link in links)
            else:
                seed = crc32(f"{effect} {kind}".encode())
                yield effect, draw_location(effect, kind, np.random.default_rng(seed))


def measure_units(jobs: int, file: Path = UNIT_SIZES) -> None:
    """Measure what is missing in the file."""
    told = json.loads(file.read_text())["sizes"] if file.is_file() else {}
    missing = [unit for unit in units() if unit.key not in told]
    floor = _gap(_answer())
    print(f"floor: {floor}", flush=True)
    results = over(partial(_measure, floor=floor), missing, jobs)
    for unit, result in zip(missing, results, strict=True):
        print(f"{unit.key}: {result}", flush=True)
        if result is None:
            continue
        told[unit.key] = result
        content = {
            "made_by": "benchmarks/blind_check.py unit-sizes",
            "floor": dataclasses.asdict(floor),
            "sizes": dict(sorted(told.items())),
        }
        atomic_write(file, json.dumps(content, indent=1) + "\n")


def _measure(unit: Unit, floor: MeasuredGap) -> dict[str, list[float]] | None:
    """Magnitudes and the gaps they make; None where none can be simulated."""
    found: dict[float, float] = {}
    magnitude = min(unit.guess, unit.limit)
    for _ in range(_TRIES):
        try:
            found[magnitude] = _gap(_with(unit, magnitude)).over(floor)
        except ShoecalError as error:
            print(f"{unit.key} {magnitude:.3g}: {error}", flush=True)
            magnitude *= 0.3
            continue
        following = min(unit.limit, _next(found))
        if abs(np.log(found[magnitude] / AIM)) < _NEAR or following in found:
            break
        magnitude = following
    if not found:
        return None
    magnitudes = sorted(found)
    return {"magnitude": magnitudes, "gap": [found[magnitude] for magnitude in magnitudes]}


def _next(found: Mapping[float, float]) -> float:
    """Where to look after magnitudes with their gaps: between them, else in proportion."""
    below = [magnitude for magnitude, gap in found.items() if gap < AIM]
    above = [magnitude for magnitude, gap in found.items() if gap >= AIM]
    if below and above:
        return float(np.sqrt(max(below) * min(above)))
    magnitude = max(below) if below else min(above)
    return magnitude * float(np.clip(own_gap(AIM) / own_gap(found[magnitude]), 0.1, 8.0))


def _answer() -> Answer:
    """A clean set, always the same."""
    return Answer(
        0, "single", _SEED, _SEED, _ORDER, 1.0, imu=True, base=PERFECT, world=middle_world()
    )


def _with(unit: Unit, magnitude: float) -> Answer:
    answer = _answer()
    if not unit.effect:
        return dataclasses.replace(
            answer, foreign=Foreign(unit.kind, magnitude, crc32(unit.key.encode()), 0.0)
        )
    rng = np.random.default_rng(crc32(unit.key.encode()))
    truth = Truth(unit.effect, unit.location, draw_size(unit.effect, magnitude, rng))
    if unit.effect == "slip":
        durations = [one.trajectory.duration for one in planned_set(answer.motions)]
        truth = slipping(answer, truth, rng, durations)
    pace = magnitude if unit.effect == "inertia" else 1.0
    return dataclasses.replace(answer, truths=(truth,), pace=pace)


def _gap(answer: Answer) -> MeasuredGap:
    with tempfile.TemporaryDirectory() as folder:
        place = Round(Path(folder))
        place.prepare()
        recorded = make_set(place, answer, rate=_RATE_HZ)
        return measure_gap(Session.open(place.recorded(answer.number)), recorded.noise)
