"""What was found, and the verdict: PASS, WARN or FAIL, with the reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.screening.faults import Fault

VERDICTS = ("PASS", "WARN", "FAIL")
"""Best first."""
MOST_LISTED = 5
"""Reasons in one message; a calibration holds them all."""


@dataclass(frozen=True)
class Finding:
    """One thing found: how bad, a line for a person, and its kind where it is a known fault."""

    verdict: str
    reason: str
    fault: Fault | None = None


@dataclass(frozen=True)
class Verdict:
    """The worst finding decides; PASS without any."""

    verdict: str
    reasons: tuple[str, ...]


def judge(findings: Sequence[Finding]) -> Verdict:
    """The verdict of all findings together."""
    for level in ("FAIL", "WARN"):
        if any(finding.verdict == level for finding in findings):
            worst_first = sorted(findings, key=lambda f: -VERDICTS.index(f.verdict))
            return Verdict(level, tuple(f"{f.verdict}: {f.reason}" for f in worst_first))
    return Verdict("PASS", ("every check passed",))


def list_reasons(reasons: Sequence[str], most: int = MOST_LISTED) -> str:
    """Reasons in one line: the first of them, and how many more there are."""
    more = len(reasons) - most
    return "; ".join([*reasons[:most], *([f"and {more} more"] if more > 0 else [])])


def split_reason(reason: str, verdict: str) -> tuple[str, str]:
    """Level and text of one of a verdict's reasons; the verdict's own where it names none."""
    level, mark, text = reason.partition(": ")
    return (level, text) if mark and level in VERDICTS else (verdict, reason)


def name_runs(numbers: Sequence[int]) -> str:
    """Some runs, in words."""
    *others, last = map(str, sorted(numbers))
    return f"runs {', '.join(others)} and {last}" if others else f"run {last}"
