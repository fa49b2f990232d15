"""Progress of long work, on standard error."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from shoecal_core.progress import Progress

QUIET_S = 10.0
"""A command says that it goes on after so long a time, and again after each."""
_TEXT = "{task.description}"


@contextmanager
def shown_progress() -> Iterator[Progress]:
    """A bar that shows what is being done and the share done (0 to 1).

    Where standard error is no terminal, each new step is one line.
    """
    console = Console(stderr=True, highlight=False, emoji=False)
    if not console.is_terminal:
        yield _lines(console)
        return
    columns = (
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn(_TEXT, markup=False),
    )
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda text, share: bar.update(task, description=text, completed=share)


@contextmanager
def still_working(name: str, every: float = QUIET_S) -> Iterator[None]:
    """Says on standard error that a command without steps of its own goes on.

    Args:
        name: of the command.
        every: between two lines [s].
    """
    console = Console(stderr=True, highlight=False, emoji=False)
    done, begin = Event(), time.monotonic()

    def report() -> None:
        while not done.wait(every):
            console.print(f"shoecal {name}: still working ({time.monotonic() - begin:.0f} s)")

    reporter = Thread(target=report, daemon=True)
    reporter.start()
    try:
        yield
    finally:
        done.set()
        reporter.join()


def _lines(console: Console) -> Progress:
    last = ""

    def report(text: str, share: float) -> None:
        nonlocal last
        if text != last:
            console.print(f"[{share:4.0%}] {text}", markup=False)
            last = text

    return report
