"""A set with its answer and what the diagnosis said, and the questions that a scorer asks of it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from blind.answers import Answer, Place, read_answers
from blind.catalogue import alike, exactly, named_once
from blind.gap import MeasuredGap, floor_of
from blind.layout import Round

CERTAIN_GAP = 1.5
"""Over the floor; smaller ones need not be found."""
NO_GAP, UNKNOWN = "no_gap", "unknown"


@dataclass(frozen=True)
class Case:
    """One set.

    Attributes:
        answer: the truth.
        gap: over the floor, as the generator measured it.
        starts: of its runs, in the simulated robot's session time [s].
        said: the diagnosis' JSON; None where it failed.
    """

    answer: Answer
    gap: float
    starts: tuple[float, ...]
    said: Mapping[str, Any] | None

    @property
    def verdict(self) -> str:
        """Of the diagnosis; `error` where there is none."""
        return "error" if self.said is None else str(self.said["verdict"])

    @property
    def found(self) -> bool:
        """Whether it says that there is a gap."""
        return self.verdict not in {NO_GAP, "error"}

    @property
    def certain(self) -> bool:
        """Whether its gap is large enough that it must be found."""
        return self.gap >= CERTAIN_GAP

    @cached_property
    def causes(self) -> list[Mapping[str, Any]]:
        """Of the explanation chosen, in its order."""
        return [] if self.said is None else list(self.said["causes"])

    @cached_property
    def ambiguity(self) -> list[Mapping[str, Any]]:
        """What cannot be told apart."""
        return [] if self.said is None else list(self.said["ambiguity_set"])

    @property
    def effects(self) -> list[str]:
        """Effects in the order in which they are named, exact twins as one, each once."""
        told = [] if self.said is None else list(self.said.get("ranking", ()))
        listed = [*self.causes, *self.ambiguity, *told]
        return list(dict.fromkeys(alike(str(one["effect"])) for one in listed))

    @property
    def places(self) -> list[Place]:
        """Effects with their places that cannot be told apart, exact twins as one, each once."""
        return list(dict.fromkeys(exactly(place_of(one)) for one in self.ambiguity))

    @property
    def true_effects(self) -> list[str]:
        """Effects that it has, exact twins as one."""
        return [alike(truth.effect) for truth in self.answer.truths]

    @property
    def true_places(self) -> list[Place]:
        """The same with their places."""
        return [exactly(truth.place) for truth in self.answer.truths]

    @property
    def first_right(self) -> bool:
        """Whether the first effect named is one that it has."""
        named = [alike(str(one["effect"])) for one in self.causes[:1]]
        return bool(named) and named[0] in self.true_effects

    @property
    def first_placed(self) -> bool:
        """Whether it is at the right place too."""
        return bool(self.causes) and exactly(place_of(self.causes[0])) in self.true_places

    def onset_error(self) -> float | None:
        """How far the onset found is off [s]; infinite where none is told; None without onset."""
        onsets = [truth for truth in self.answer.truths if truth.onset is not None]
        if not onsets:
            return None
        truth = onsets[0]
        assert truth.onset is not None
        begin = self.starts[0] if truth.run is None else 0.0
        told: list[float] = []
        for cause in self.causes:
            same_run = truth.run is None or cause.get("run") == truth.run
            if cause["effect"] == truth.effect and "time" in cause["size"] and same_run:
                told.append(float(cause["size"]["time"]["value"]))
        if not told and self.said is not None:
            told = [self._since(place, truth.run) for place in self.said["where"]]
        return min((abs(time - (truth.onset - begin)) for time in told), default=float("inf"))

    def _since(self, place: Mapping[str, Any], run: int | None) -> float:
        """Onset at a place, since the true one's run, else since the session began [s]."""
        onset, here = place["onset_s"], place["run"]
        if onset is None or here is None or (run is not None and here != run):
            return float("inf")
        start = self.starts[int(here) - 1] - self.starts[0] if run is None else 0.0
        return start + float(onset)

    def held(self) -> list[bool]:
        """Of every size told of an effect that it has: whether the 95 % interval holds the true."""
        found = []
        for cause in self.causes:
            for truth in self.answer.truths:
                if cause["effect"] != truth.effect or named_once(
                    tuple(cause["location"])
                ) != named_once(truth.location):
                    continue
                for name, told in cause["size"].items():
                    if name in truth.size:
                        true = truth.size[name]
                        if name == "time" and truth.effect == "stuck_cell":
                            true -= self.starts[0]
                        low, high = told["ci95"]
                        found.append(bool(low <= true <= high))
        return found


def place_of(told: Mapping[str, Any]) -> Place:
    """Effect and location of an entry of the diagnosis."""
    return Place(str(told["effect"]), tuple(told["location"]))


def load_cases(place: Round) -> tuple[list[Case], Mapping[bool, MeasuredGap], int]:
    """All sets that could be made and were diagnosed; the floors; how many could not be made.

    Floors are of robots as built (True) and of perfect ones (False).
    """
    answers = read_answers(place)
    made = {one.number: json.loads(place.made(one.number).read_text()) for one in answers}
    gaps = {number: MeasuredGap.told(came) for number, came in made.items() if "failed" not in came}
    clean = [one for one in answers if one.category == "clean" and one.number in gaps]
    floors = {
        kind: floor_of(
            [gaps[one.number] for one in clean if one.as_built is kind] or [*gaps.values()]
        )
        for kind in (True, False)
    }
    cases = []
    for answer in answers:
        file = place.diagnosis(answer.number)
        if answer.number in gaps and file.is_file():
            starts = tuple(made[answer.number]["starts"])
            cases.append(
                Case(
                    answer,
                    gaps[answer.number].over(floors[answer.as_built]),
                    starts,
                    read_diagnosis(file.read_text()),
                )
            )
    return cases, floors, len(answers) - len(gaps)


def variant_cases(place: Round, cases: Sequence[Case], variant: str) -> list[Case]:
    """The same sets as a variant of the diagnosis saw them, as far as it did."""
    found = []
    for case in cases:
        file = place.diagnosis(case.answer.number, variant)
        if file.is_file():
            found.append(dataclasses.replace(case, said=read_diagnosis(file.read_text())))
    return found


def read_diagnosis(text: str) -> Mapping[str, Any] | None:
    """What a diagnosis said; None where it failed."""
    told: dict[str, Any] = json.loads(text)
    return told if "verdict" in told else None
