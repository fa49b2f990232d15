"""Which lines of code follow each other when an input is read, and inputs chosen by it."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

Edge = tuple[str, int, int]
"""File, line before, line: of one run of a function."""
Mutate = Callable[[bytes, bytes, random.Random], bytes]
"""Draws a child of an input; the second one is another of the corpus."""


class Tracer:
    """Collects the edges that were run in some files."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.edges: set[Edge] = set()
        self._files = {str(file) for file in files}
        self._before: dict[FrameType, int] = {}

    def __call__(self, frame: FrameType, event: str, _: object) -> Any:
        """As sys.settrace calls it."""
        name = frame.f_code.co_filename
        if name not in self._files:
            return None
        if event == "line":
            self.edges.add((name, self._before.get(frame, 0), frame.f_lineno))
            self._before[frame] = frame.f_lineno
        elif event == "return":
            self._before.pop(frame, None)
        return self

    def trace(self, job: Callable[[], None]) -> None:
        """Run a job, whatever it raises."""
        outer = sys.gettrace()
        sys.settrace(self)
        try:
            job()
        finally:
            sys.settrace(outer)
            self._before.clear()


class Corpus:
    """Inputs that each reached something new."""

    def __init__(self, seeds: Sequence[bytes], mutate: Mutate, rng: random.Random) -> None:
        self.inputs = list(seeds)
        self.edges: set[Edge] = set()
        self._mutate = mutate
        self._rng = rng

    def draw(self, turn: int) -> bytes:
        """The seeds first, then children, of later inputs rather than of earlier ones."""
        if turn < len(self.inputs):
            return self.inputs[turn]
        late = max(self._rng.random(), self._rng.random())
        parent = self.inputs[int(late * len(self.inputs))]
        return self._mutate(parent, self._rng.choice(self.inputs), self._rng)

    def learn(self, data: bytes, edges: set[Edge]) -> None:
        """Keep an input that reached what none had reached."""
        if not edges <= self.edges:
            self.edges |= edges
            self.inputs.append(data)
