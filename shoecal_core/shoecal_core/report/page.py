"""What a report page consists of, whatever it reports on: verdict, key figures, sections."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.errors import ShoecalError
from shoecal_core.report.player import Player

LEVELS = ("PASS", "WARN", "FAIL")


@dataclass(frozen=True)
class Reason:
    """Why a verdict is what it is, with the cure: one line."""

    level: str
    text: str

    def __post_init__(self) -> None:
        _check_level(self.level)


@dataclass(frozen=True)
class PageVerdict:
    """The first thing to read.

    Attributes:
        level: PASS, WARN or FAIL.
        meaning: what it means for the user, in a sentence.
        reasons: worst first.
        label: shown in the level's place; empty: the level itself.
        lines: what there is to say before the reasons, a paragraph each.
    """

    level: str
    meaning: str
    reasons: tuple[Reason, ...]
    label: str = ""
    lines: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_level(self.level)


@dataclass(frozen=True)
class KeyFigure:
    """A number that matters: label, number with unit, a line on how to take it."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes:
        title, caption: above and below it.
        svg: an `<svg>` element.
        tall: it is about twice as high as the others of its row.
    """

    title: str
    svg: str
    caption: str = ""
    tall: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of text; the first cell of each names it.

    Attributes:
        title: above it.
        header: one heading a column.
        rows: as long as the header.
        note: below it.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ShoecalError(
                    f"table '{self.title}': a row has {len(row)} cells, its header "
                    f"{len(self.header)}"
                )


@dataclass(frozen=True)
class Group:
    """What stands under one subheading (none where the title is empty).

    Attributes:
        folded: only the subheading is shown until it is clicked; the whole is printed.
    """

    title: str = ""
    text: str = ""
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()
    player: Player | None = None
    folded: bool = False


@dataclass(frozen=True)
class Section:
    """A part of the page with a heading that can be jumped to."""

    title: str
    groups: tuple[Group, ...]
    text: str = ""


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes:
        title, subtitle: what it is on.
        verdict: comes first.
        key_figures: come next.
        sections: figures first, details last.
        provenance: lines that say what is simulated, what is real, and where it is from.
    """

    title: str
    subtitle: str
    verdict: PageVerdict
    key_figures: tuple[KeyFigure, ...]
    sections: tuple[Section, ...]
    provenance: tuple[str, ...]

    @property
    def animated(self) -> bool:
        """Whether there is anything to play; no other page runs a script."""
        return any(group.player for section in self.sections for group in section.groups)


def _check_level(level: str) -> None:
    if level not in LEVELS:
        raise ShoecalError(f"'{level}' is no verdict; use one of {', '.join(LEVELS)}")
