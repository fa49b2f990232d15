"""Several sessions in one command: each by itself, over cores or a cluster, as they end."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from rich.console import Console
from rich.markup import escape

from shoecal_core.cli.arguments import require_folder
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.tables import TEXT, new_table, print_table
from shoecal_core.errors import PartialError, ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.recording.errors import SessionError
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.many_jobs import ENDED, over_cluster, over_cores

EACH = "for several sessions one each, FILE_SESSION"
"""Ends the help of an option that names a file to write."""
FAILED = "failed"
"""Stands for the verdict of a session without one."""


class Found(Protocol):
    """What a command finds in one session."""

    def to_json(self) -> Mapping[str, object]:
        """Its figures, as the command writes them for one session."""


R = TypeVar("R", bound=Found)


@dataclass(frozen=True)
class Figures:
    """What is found where nothing but its figures is needed further on."""

    content: Mapping[str, object]

    def to_json(self) -> Mapping[str, object]:
        """They themselves."""
        return self.content


@dataclass(frozen=True)
class SessionJob(Generic[R]):
    """What to do with one session, wherever that is done.

    Attributes:
        session: its folder.
        work: does it and prints what it finds; can be pickled.
    """

    session: Path
    work: Callable[[Console], R]


@dataclass(frozen=True)
class Ended(Generic[R]):
    """What came of a job.

    Attributes:
        session: its folder.
        found: in it; None where there is an error.
        figures: of what was found, though it may be unfit for use.
        error: that stopped the job or makes what was found unfit; empty: none.
    """

    session: Path
    found: R | None = None
    figures: Mapping[str, object] = field(default_factory=dict)
    error: str = ""

    def to_json(self) -> dict[str, object]:
        """Figures under the name of the session, and the error."""
        return {
            "session": str(self.session),
            **self.figures,
            **({"error": self.error} if self.error else {}),
        }


def add_sessions(parser: argparse.ArgumentParser, more: str = "; several at once") -> None:
    """`SESSION …`; `more` ends its help."""
    parser.add_argument(
        "sessions",
        type=Path,
        nargs="+",
        metavar="SESSION",
        help=f"folder of a recorded session{more}",
    )


def add_spread(parser: argparse.ArgumentParser) -> None:
    """`--jobs` and `--scheduler`."""
    parser.add_argument(
        "--jobs", type=_jobs, metavar="N", help="sessions at a time (default: one a core)"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="spread sessions over this Dask scheduler's workers"
    )


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number, 1 or more")
    return int(text)


def several(args: argparse.Namespace) -> bool:
    """Whether sessions are done in other processes, and listed in one table."""
    return len(args.sessions) > 1 or args.scheduler is not None


def named_sessions(args: argparse.Namespace) -> list[Path]:
    """The sessions that are named; for workers elsewhere as whole paths.

    Raises:
        SessionError: one is named twice.
    """
    seen = set()
    for session in args.sessions:
        if session.resolve() in seen:
            raise SessionError(session, "is named twice; name each session once")
        seen.add(session.resolve())
    return [for_workers(args, session) for session in args.sessions]


def for_workers(args: argparse.Namespace, path: Path) -> Path:
    """A path as it is handed to a job: whole where that may run in another folder."""
    return path if args.scheduler is None else path.absolute()


def output_files(args: argparse.Namespace, *options: str) -> list[dict[str, Path]]:
    """Files to write, by option, of each session: FILE, or of several sessions FILE_SESSION.

    Args:
        args: sessions, options and `json`.
        options: that name a file to write; one that is not given is left out.

    Raises:
        FileError: a folder is missing, or a file is one.
        ShoecalError: a file would be written for two sessions, or by two options.
    """
    named = {one: path for one in options if (path := getattr(args, one)) is not None}
    for path in filter(None, (*named.values(), args.json)):
        require_folder(path)
    if len(args.sessions) == 1:
        return [{one: for_workers(args, path) for one, path in named.items()}]
    files = [
        {one: for_workers(args, _of_session(path, session)) for one, path in named.items()}
        for session in args.sessions
    ]
    taken: set[Path] = set() if args.json is None else {args.json.absolute()}
    for session, own in zip(args.sessions, files, strict=True):
        for option, path in own.items():
            if path.absolute() in taken:
                raise ShoecalError(
                    f"--{option}: {path}, for session {session}, would be written twice; give "
                    "session folders names that differ, and each option a file of its own"
                )
            taken.add(path.absolute())
    return files


def _of_session(path: Path, session: Path) -> Path:
    return path.with_name(f"{path.stem}_{session.resolve().name}{path.suffix}")


def one_a_session(
    args: argparse.Namespace, option: str, paths: Sequence[Path]
) -> list[Path] | list[None]:
    """A file that is read, of each session: the one for all, or the session's own; None: none.

    Raises:
        ShoecalError: there are neither one nor as many as sessions.
    """
    count = len(args.sessions)
    if not paths:
        return [None] * count
    if len(paths) not in {1, count}:
        raise ShoecalError(
            f"{option} was given {len(paths)} times for {count} session(s); give it once "
            "for all, or once a session in their order"
        )
    whole = [for_workers(args, path) for path in paths]
    return whole * count if len(whole) == 1 else whole


def over_sessions(
    args: argparse.Namespace,
    jobs: Sequence[SessionJob[R]],
    console: Console,
    columns: Mapping[str, Callable[[Ended[R]], str]],
) -> Mapping[str, object]:
    """Do the work of a single session here; else do all and show a line each.

    Args:
        args: `jobs`, `scheduler` and `json`, which is written whenever a session ends.
        jobs: one a session.
        console: for the table.
        columns: what stands in the table next to the session, by heading.

    Raises:
        ShoecalError: by the single session.
        PartialError: some have failed; the figures of all are with it.
    """
    if not several(args):
        return jobs[0].work(console).to_json()
    ended = each_session(args, jobs)
    print_sessions(ended, console, columns)
    figures = figures_of(ended)
    raise_failed(ended, figures)
    return figures


def each_session(args: argparse.Namespace, jobs: Sequence[SessionJob[R]]) -> list[Ended[R]]:
    """What comes of each job, in their order; as of `over_sessions`."""
    results: dict[int, Ended[R]] = {}
    with shown_progress() as progress:
        progress(f"{len(jobs)} session{'s' * (len(jobs) > 1)}", 0.0)
        coming: Iterator[tuple[int, Ended[R]]] = (
            over_cores(_attempt, jobs, args.jobs, lost=_lost)
            if args.scheduler is None
            else over_cluster(_attempt, jobs, args.scheduler, lost=_lost)
        )
        for number, ended in coming:
            results[number] = ended
            progress(f"{ended.session}", len(results) / len(jobs))
            if args.json is not None:  # what is done stays, whatever becomes of the others
                done = [results[number] for number in sorted(results)]
                left = [job.session for number, job in enumerate(jobs) if number not in results]
                figures = figures_of(done, left)
                atomic_write(args.json, json.dumps(figures, indent=1, allow_nan=False) + "\n")
    return [results[number] for number in range(len(jobs))]


def _attempt(job: SessionJob[R]) -> Ended[R]:
    """One bad session does not stop the others."""
    try:
        found = job.work(Console(quiet=True))
        return Ended(job.session, found, found.to_json())
    except ShoecalError as error:
        figures = error.figures if isinstance(error, PartialError) else {}
        return Ended(job.session, figures=figures, error=str(error))


def _lost(job: SessionJob[R]) -> Ended[R]:
    """What stands for a job whose process or worker ended before it."""
    return Ended(job.session, error=f"{job.session}: {ENDED}")


def figures_of(ended: Sequence[Ended[R]], waiting: Sequence[Path] = ()) -> dict[str, object]:
    """Sessions that are done, in the order in which they were named, and those that are not yet."""
    left = {"waiting": list(map(str, waiting))} if waiting else {}
    return {"format": 1, "sessions": [one.to_json() for one in ended], **left}


def print_sessions(
    ended: Sequence[Ended[R]],
    console: Console,
    columns: Mapping[str, Callable[[Ended[R]], str]],
) -> None:
    """A line a session; the last column may wrap and has the error of one without figures."""
    table = new_table("Sessions")
    *_, last = columns
    for name in ("session", *columns):
        table.add_column(name, overflow=TEXT if name in {"session", last} else "ellipsis")
    for one in ended:
        cells = {name: cell(one) if one.figures else "-" for name, cell in columns.items()}
        if not one.figures:
            cells |= {"verdict": FAILED, last: one.error}
        table.add_row(escape(str(one.session)), *map(escape, cells.values()))
    print_table(console, table)


def _expected_cop(one: Ended[R], foot: str) -> str:
    figures: Mapping[str, Any] = one.figures
    if figures["assessment"] is None:
        return "-"
    return f"{figures['assessment']['expected_error'][foot]['cop_mae_mm']:.2f}"


EXPECTED: Mapping[str, Callable[[Ended[Figures]], str]] = {
    f"{foot} CoP ± (mm)": partial(_expected_cop, foot=foot) for foot in FEET
}
"""Columns of the expected CoP error of each foot, of figures with an `assessment`."""


def raise_failed(ended: Sequence[Ended[R]], figures: Mapping[str, object]) -> None:
    """Refuse to pass over sessions that have failed.

    Raises:
        PartialError: with the figures of all of them.
    """
    failed = [one for one in ended if one.error]
    if failed:
        errors = "; ".join(
            one.error if str(one.session) in one.error else f"{one.session}: {one.error}"
            for one in failed
        )
        raise PartialError(f"{len(failed)} of {len(ended)} sessions failed: {errors}", figures)
