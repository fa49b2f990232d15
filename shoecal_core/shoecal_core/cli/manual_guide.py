"""The guide of a manual calibration at a terminal: keys in, readings in, a live line out."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from rich.console import Console

from shoecal_core.arrays import FloatArray
from shoecal_core.cli.manual_guide_frames import LineProblem
from shoecal_core.cli.manual_guide_streams import FrameStream
from shoecal_core.cli.prose import say
from shoecal_core.errors import ShoecalError
from shoecal_core.manual.guide import Guide, GuidePhase, Key
from shoecal_core.manual.loads import Load
from shoecal_core.manual.measurements import Measurements
from shoecal_core.shoe.shoe import FEET, Shoe

KEYS = {
    b"\n": Key.READ,
    b"\r": Key.READ,
    b" ": Key.READ,
    b"r": Key.REPEAT,
    b"b": Key.BACK,
    b"s": Key.SKIP,
    b"q": Key.STOP,
    b"": Key.STOP,  # end of what is typed
}
HELP = "Enter: read   r: the last one again   b: back   s: skip   q: stop, nothing is lost"
EVERY = 5
"""Frames from one live line to the next."""


class StoppedError(ShoecalError):
    """The person stopped before the end; what was read stands in the file."""


def guide_person(
    guide: Guide,
    stream: FrameStream,
    save: Callable[[Measurements], None],
    shown: Callable[[Load, FloatArray], str],
    console: Console,
) -> None:
    """Lead a person through the guide's plan.

    Args:
        guide: at its beginning.
        stream: of readings.
        save: keeps measurements, called after every reading that was accepted.
        shown: readings (n,), in the channels' unit, under a load as a person wants to see them.
        console: what is said goes there; the live line only where it is a terminal.

    Raises:
        StoppedError: when it was left before its end.
        ShoecalError: when the readings end, or cannot be read.
    """
    with _keyboard() as keyboard:
        _Session(guide, stream, save, shown, console, keyboard).run()
    if guide.phase is GuidePhase.STOPPED:
        raise StoppedError(
            f"stopped with {guide.pending} of {len(guide.plan)} loads left; the same command goes "
            "on from there"
        )


def instruction(shoe: Shoe, load: Load) -> str:
    """What a person has to do for a load."""
    if load.alone:
        if not load.mass:
            return f"{load.place}, off its shoe: leave it free of any weight"
        return f"{load.place}, off its shoe: let it bear {load.mass:g} kg"
    side = FEET[load.foot]
    if not load.place:
        return f"{side} shoe: stand it on the floor, with nothing on it"
    holes = shoe.holes[load.foot]
    x, y = (0.0, 0.0) if holes is None else 1e3 * holes.position(load.place)
    return f"{side} shoe: put {load.mass:g} kg in hole {load.place} (x {x:.0f}, y {y:.0f} mm)"


class _Session:
    """One sitting."""

    def __init__(
        self,
        guide: Guide,
        stream: FrameStream,
        save: Callable[[Measurements], None],
        shown: Callable[[Load, FloatArray], str],
        console: Console,
        keyboard: int,
    ) -> None:
        self._guide = guide
        self._stream = stream
        self._save = save
        self._shown = shown
        self._console = console
        self._keyboard = keyboard
        self._asked: tuple[Load, GuidePhase] | None = None
        self._saved = guide.measurements
        self._count = 0

    def run(self) -> None:
        guide = self._guide
        self._console.print(HELP, style="dim")
        self._show_task()
        while guide.phase in {GuidePhase.ASKING, GuidePhase.READING}:
            keys, lines = self._wait()
            # First the keys: what comes after one belongs to it.
            if keys:
                self._press(os.read(self._keyboard, 1))
            if lines:
                self._stream.receive()
            if self._wanted:
                self._take()
            if self._stream.ended and self._wanted and not self._stream.waiting:
                raise self._stream.complain()

    @property
    def _wanted(self) -> bool:
        """A live stream is read all the time; a file only where its readings are asked for."""
        return self._stream.live or self._guide.phase is GuidePhase.READING

    def _wait(self) -> tuple[bool, bool]:
        """Wait for a key or for readings; whether there is a key, and whether readings."""
        typed = os.isatty(self._keyboard) or self._guide.phase is GuidePhase.ASKING
        sources = [self._keyboard] if typed else []
        # What has been received already must not wait for more.
        ready = self._wanted and self._stream.waiting
        if self._wanted and not ready and not self._stream.ended:
            sources.append(self._stream.descriptor)
        found, *_ = select.select(sources, [], [], 0.0 if ready else None)
        return self._keyboard in found, self._stream.descriptor in found

    def _press(self, typed: bytes) -> None:
        key = KEYS.get(typed.lower())
        if key is not None:
            self._guide.press(key)
            self._show_task()

    def _take(self) -> None:
        guide = self._guide
        for found in self._stream.frames():
            if isinstance(found, LineProblem):
                self._live(found.text)
                continue
            load = guide.load
            guide.take(found.readings, found.stamp_ns)
            if guide.measurements is not self._saved:
                self._keep(load)
            self._show_task()
            self._count += 1
            if self._count % EVERY == 0:
                taken = f"{guide.gathered} samples   " if guide.phase is GuidePhase.READING else ""
                self._live(taken + self._shown(guide.load, found.readings))
            if not self._wanted or guide.phase is GuidePhase.COMPLETE:
                break

    def _keep(self, load: Load) -> None:
        """Save the reading that has just been accepted."""
        self._saved = self._guide.measurements
        self._save(self._saved)
        shoe = self._saved.shoe
        readings = np.full(len(shoe.names), np.nan)
        entry = next(one for one in self._saved.entries if one.load == load)
        readings[shoe.of_foot(load.foot)] = entry.mean
        self._say(f"  read: {self._shown(load, readings)}")

    def _show_task(self) -> None:
        """Say what is to be done, once."""
        guide = self._guide
        if guide.phase in {GuidePhase.COMPLETE, GuidePhase.STOPPED}:
            self._live("")
            return
        news = guide.news()
        if news:
            self._say(f"  {news}")
        before, self._asked = self._asked, (guide.load, guide.phase)
        if self._asked == before and not news:
            return
        if guide.phase is GuidePhase.READING:
            self._say("  reading: hold still")
            return
        what = instruction(guide.measurements.shoe, guide.load)
        self._say(f"{guide.number} of {len(guide.plan)}  {what}, then Enter")

    def _say(self, text: str) -> None:
        self._live("")
        say(self._console, text)

    def _live(self, text: str) -> None:
        """Rewrite the line that the cursor stands in."""
        if self._console.is_terminal:
            self._console.file.write(f"\r\x1b[K{text[: self._console.width - 1]}")
            self._console.file.flush()


@contextmanager
def _keyboard() -> Iterator[int]:
    """Standard input, key by key where it is a terminal."""
    descriptor = sys.stdin.fileno()
    if not os.isatty(descriptor):
        yield descriptor
        return
    before = termios.tcgetattr(descriptor)
    try:
        tty.setcbreak(descriptor)
        yield descriptor
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
