"""One CSV file, its columns read with errors that name column and line."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.errors import FieldError, FileSyntaxError
from shoecal_core.files import read_error
from shoecal_core.recording.run import Floats


@dataclass(frozen=True)
class Column:
    """A column and the factor its numbers take to become the quantity wanted."""

    name: str
    scale: float = 1.0


class Table:
    """Rows of a CSV file below its header.

    Attributes:
        path: the file.
        names: of its columns.
    """

    def __init__(self, path: Path, separator: str, decimal: str) -> None:
        """Read a file.

        Raises:
            FileMissingError, FileUnreadableError: cannot be read.
            FileSyntaxError: is no CSV file, has no rows, or rows of unequal length.
        """
        self.path = path
        self._decimal = decimal
        self._lines: list[int] = []
        self._rows: list[list[str]] = []
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                reader = csv.reader(file, delimiter=separator)
                self.names = [name.strip() for name in next(reader, [])]
                for row in reader:
                    if row:
                        self._rows.append(row)
                        self._lines.append(reader.line_num)
        except OSError as error:
            raise read_error(path, error) from error
        except (UnicodeDecodeError, csv.Error) as error:
            raise FileSyntaxError(path, f"is no CSV file in UTF-8 ({error})") from error
        if not self._rows:
            raise FileSyntaxError(path, "has no rows below its header")
        for line, row in zip(self._lines, self._rows, strict=True):
            if len(row) != len(self.names):
                raise FileSyntaxError(
                    path,
                    f"{len(row)} values for {len(self.names)} columns; check the separator",
                    field=f"line {line}",
                )

    def __len__(self) -> int:
        return len(self._rows)

    def read(self, column: Column) -> Floats:
        """Numbers (T,) of a column, scaled.

        Raises:
            FieldError: no such column, two of it, or something that is no finite number.
        """
        if self.names.count(column.name) != 1:
            problem = "is there twice" if column.name in self.names else "is missing"
            raise FieldError(
                self.path,
                f"{problem} (there are: {', '.join(self.names)}); correct the mapping or the file",
                field=f"column '{column.name}'",
            )
        index = self.names.index(column.name)
        numbers = np.empty(len(self))
        for place, row in enumerate(self._rows):
            try:
                numbers[place] = float(row[index].replace(self._decimal, "."))
            except ValueError:
                numbers[place] = math.nan
        if not np.isfinite(numbers).all():
            place = int(np.flatnonzero(~np.isfinite(numbers))[0])
            raise self.error(column.name, place, f"'{self._rows[place][index]}' is not a number")
        return numbers * column.scale

    def read_all(self, columns: tuple[Column, ...]) -> Floats:
        """Numbers (T, c) of several columns."""
        return np.column_stack([self.read(column) for column in columns])

    def line(self, place: int) -> int:
        """Line of the file, from 1, by a row's place below the header."""
        return self._lines[place]

    def error(self, column: str, place: int, problem: str) -> FieldError:
        """The error to raise for one value, by its place below the header."""
        return FieldError(self.path, problem, field=f"column '{column}', line {self.line(place)}")
