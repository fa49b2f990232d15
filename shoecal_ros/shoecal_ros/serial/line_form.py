"""The form of text lines that hold words and units next to their numbers."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

VALUE, SKIPPED = "{}", "{_}"
"""Stand in a form for a number that counts, and for one that does not."""
_NUMBER = r"[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?+"
_NONE = r"[+-]?(?:nan|inf|ovf)"
_PARTS = re.compile(r"(\{_?\}|\s+)")


@dataclass(frozen=True)
class LineForm:
    """A line as the firmware prints it, with `{}` for every number that counts.

    Attributes:
        text: the form, for a person: `Reading: {} lbs calibration_factor: {_}`.
        pattern: of a whole line; blanks may be as many as they will.
    """

    text: str
    pattern: re.Pattern[str]

    @staticmethod
    def of(text: str) -> LineForm:
        """Read a form.

        Raises:
            ValueError: without a `{}`, or with two numbers that nothing keeps apart.
        """
        if VALUE not in text:
            raise ValueError(f"has no {VALUE}; put one in place of each number that counts")
        if re.search(r"\}\{", text):
            raise ValueError("has two numbers with nothing between them")
        kinds = {VALUE: f"({_NUMBER}|{_NONE})", SKIPPED: f"(?:{_NUMBER}|{_NONE})"}
        parts = [
            kinds.get(part) or (r"\s*+" if part.isspace() else re.escape(part))
            for part in _PARTS.split(text.strip())
        ]
        return LineForm(text, re.compile("".join(parts), re.IGNORECASE))

    @property
    def count(self) -> int:
        """Numbers of a line that count."""
        return self.text.count(VALUE)

    def numbers(self, line: str) -> list[float] | None:
        """Of a line of this form, NaN where the firmware printed none; None of any other line."""
        match = self.pattern.fullmatch(line)
        if match is None:
            return None
        return [_number(one) for one in match.groups()]


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
