"""One CSV file, its columns read with errors that name column and line."""

from __future__ import annotations

import csv
import itertools
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, FileSyntaxError
from shoecal_core.files import read_error

NO_VALUE = frozenset(("", "nan", "na", "n/a", "null", "none"))
"""What stands in a table where there is no value, in small letters."""


@dataclass(frozen=True)
class CsvColumn:
    """A column and the factor its numbers take to become the quantity wanted."""

    name: str
    scale: float = 1.0


@dataclass(frozen=True)
class Layout:
    """How the files of a recording are written.

    Attributes:
        separator, decimal: one character each.
        lines_before_header: that are skipped above the names of the columns.
        lines_after_header: that are skipped below them, such as a row of units.
    """

    separator: str = ","
    decimal: str = "."
    lines_before_header: int = 0
    lines_after_header: int = 0


FEW_SHARE = 0.01
"""Of the rows, that may be damaged; where more are of another length it is the layout."""
_SEPARATORS = (";", "\t", ",", "|")
_DATE = re.compile(r"\d[-/]\d+[-/]\d|\d:\d\d")


class CsvTable:
    """Rows of a CSV file below its header.

    Attributes:
        path: the file.
        names: of its columns.
        decimal: the character before decimals.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        """Read a file.

        Raises:
            FileMissingError, FileUnreadableError: cannot be read.
            FileSyntaxError: is no CSV file, has no rows, or rows of unequal length.
        """
        self.path = path
        self._separator, self.decimal = layout.separator, layout.decimal
        self._lines: list[int] = []
        self._rows: list[list[str]] = []
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                for _ in range(layout.lines_before_header):
                    next(file, "")
                reader = csv.reader(file, delimiter=layout.separator)
                self.names = [name.strip() for name in next(reader, [])]
                for row in itertools.islice(reader, layout.lines_after_header, None):
                    if row:
                        self._rows.append(row)
                        self._lines.append(layout.lines_before_header + reader.line_num)
        except OSError as error:
            raise read_error(path, error) from error
        except UnicodeDecodeError as error:
            raise FileSyntaxError(path, "is no text in UTF-8; export it as such") from error
        except csv.Error as error:
            raise FileSyntaxError(path, f"is no CSV file ({error})") from error
        if not self._rows:
            raise FileSyntaxError(path, "has no rows below its header")
        self._check_shape()

    def _check_shape(self) -> None:
        """Refuse a header that names no columns, and rows of other lengths."""
        if problem := self._header_problem():
            raise FileSyntaxError(self.path, problem, field="header")
        ragged = [at for at, row in enumerate(self._rows) if len(row) != len(self.names)]
        if ragged:
            line, row = self._lines[ragged[0]], self._rows[ragged[0]]
            problem = f"{len(row)} values for {len(self.names)} columns in the header"
            cure = self._why_ragged(line, row, len(ragged))
            raise FileSyntaxError(self.path, f"{problem}; {cure}", field=f"line {line}")

    def _header_problem(self) -> str:
        """Why the first line read does not name columns, with the cure; empty where it may."""
        first = self.names[0] if self.names else ""
        if first.lower().startswith("sep="):
            separator = first[4:5] or self._separator
            return (
                f"'{first}' is a note of spreadsheets on their separator: add lines_before_header: "
                f"1 and separator: '{separator}' to the mapping"
            )
        if len(self.names) > 1 and all(math.isfinite(self._number(name)) for name in self.names):
            return "holds numbers, not names of columns: write these above the first line"
        return ""

    def _why_ragged(self, line: int, row: list[str], count: int) -> str:
        """The cure of `count` rows that have more or fewer values than there are columns."""
        if any("\0" in value for value in row):
            why = "it holds zero bytes, as where power was lost while the file was written"
            return f"{why}: delete the line"
        if line == self._lines[-1] and len(row) < len(self.names):
            return "the file is cut there: delete its last line"
        if cure := self._other_separator():
            return cure
        if len(self.names) > 1 and count <= FEW_SHARE * len(self._rows):
            return f"correct or delete the line ({count} of {len(self._rows)} are so)"
        return "check the separator, or skip what stands above the header ('lines_before_header')"

    def _other_separator(self) -> str:
        """The cure of a header that is one name by the mapping's separator; empty of any other."""
        marks = [mark for mark in _SEPARATORS if len(self.names) == 1 and mark in self.names[0]]
        return f"add separator: {marks[0]!r} to the mapping" if marks else ""

    def __len__(self) -> int:
        return len(self._rows)

    def read(self, column: CsvColumn, *, gaps: bool = False) -> FloatArray:
        """Numbers (T,) of a column, scaled.

        Args:
            column: which.
            gaps: take what is empty or NaN as NaN: a value that is not there.

        Raises:
            FieldError: no such column, two of it, or something that is no finite number.
        """
        if self.names.count(column.name) != 1:
            problem = "is there twice" if column.name in self.names else "is missing"
            cure = self._other_separator() or "correct the mapping or the file"
            there = ", ".join(self.names).replace("\t", " ")
            raise FieldError(
                self.path,
                f"{problem} (there are: {there}); {cure}",
                field=f"column '{column.name}'",
            )
        index = self.names.index(column.name)
        numbers = np.array([self._number(row[index]) for row in self._rows])
        wrong = ~np.isfinite(numbers)
        if gaps:
            wrong &= [row[index].strip().lower() not in NO_VALUE for row in self._rows]
        if wrong.any():
            place = int(np.flatnonzero(wrong)[0])
            text, following = (row[index] for row in (self._rows[place : place + 2] * 2)[:2])
            raise self.error(column.name, place, self._why(text, place, following))
        return numbers * column.scale

    def texts(self, column: CsvColumn) -> list[str]:
        """What stands in a column that is there, T texts."""
        index = self.names.index(column.name)
        return [row[index] for row in self._rows]

    def _number(self, text: str) -> float:
        """NaN where it is none."""
        if self.decimal != "." and "." in text:
            return math.nan
        try:
            return float(text.replace(self.decimal, "."))
        except ValueError:
            return math.nan

    def _why(self, text: str, place: int, following: str) -> str:
        """What is wrong with a value, by its place below the header and the value after it."""
        if self.decimal != "." and "." in text:
            return (
                f"'{text}' has a '.', but 'decimal' is '{self.decimal}'; export the file without "
                "thousands separators, or correct 'decimal'"
            )
        fault = f"'{text}' is not a number"
        if self.decimal == "." and "," in text:
            return f"{fault}; does the mapping lack decimal: ','?"
        if text.strip() in self.names:
            return (
                f"{fault}, but the header again, as where two logs are in one file: cut it there, "
                "and make each a trial of its own"
            )
        if _DATE.search(text):
            return f"{fault}, but a date or time of day; write it as seconds since 1970"
        if place == 0 and math.isfinite(self._number(following)):
            return f"{fault}; skip a row of units below the header with 'lines_after_header: 1'"
        return f"{fault}; leave the value empty where there is none, or correct the file"

    def read_all(self, columns: tuple[CsvColumn, ...]) -> FloatArray:
        """Numbers (T, c) of several columns, NaN in their gaps; see `read`."""
        return np.column_stack([self.read(column, gaps=True) for column in columns])

    def line(self, place: int) -> int:
        """Line of the file, from 1, by a row's place below the header."""
        return self._lines[place]

    def error(self, column: str, place: int, problem: str) -> FieldError:
        """The error to raise for one value, by its place below the header."""
        return FieldError(self.path, problem, field=f"column '{column}', line {self.line(place)}")
