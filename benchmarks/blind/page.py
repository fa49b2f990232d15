"""The tables of a round: sections of docs/evidence/diagnosis.md, and out/blind.json."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from blind.cases import NO_GAP, UNKNOWN, Case
from blind.catalogue import EFFECTS, NEAR_TWINS, alike
from blind.figures import FAR, Figure
from pages import Row, markdown, write_section
from shoecal_core.files import atomic_write

PAGE = Path("docs/evidence/diagnosis.md")
FIGURE = Path("docs/figures/blind-detection.svg")
JSON = Path("out/blind.json")
"""Within the project."""
NOTHING = "nothing"
CONFUSED_MAX = 12
"""Rows of the table of confused effects."""
COMPARED = (
    "found", "false_alarms", "right_first", "right_among_three", "truth_in_set", "set_size",
    "exact_place", "known_called_unknown",
)  # fmt: skip
"""Figures of which variants are compared."""

Figures = Mapping[str, Figure]


def write(
    about: Mapping[str, object],
    figures: Mapping[str, Figures],
    cases: Sequence[Case],
    ablations: Mapping[str, Figures],
    entries: Sequence[Row],
    project: Path,
) -> None:
    """Write the tables and the JSON.

    Args:
        about: the round: its command, seal, sets and noise floor.
        figures: by kind of worlds and key.
        cases: of the round.
        ablations: figures with something switched off, by what.
        entries: figures of the diagnosis and of others, one row each.
        project: folder whose page and JSON are written.
    """
    tables: dict[str, Sequence[Row]] = {
        "blind-round": [{"round": key, "value": value} for key, value in about.items()],
        **{
            f"blind-{name.replace(' ', '-')}": [_row(figure) for figure in of.values()]
            for name, of in figures.items()
        },
        "blind-classes": _classes(cases),
        "blind-confused": _confused(cases),
        "blind-ablations": [_compared(name, found) for name, found in ablations.items()],
    }
    if entries:
        tables["blind-compared"] = entries
    for name, rows in tables.items():
        write_section(name, markdown(rows) if rows else "None.", project / PAGE)
    content = {
        **about,
        "figures": {
            name: {key: figure.to_json() for key, figure in of.items()}
            for name, of in figures.items()
        },
        "confusion": confusion(cases, by_class=False),
        "compared": list(entries),
        "ablations": {
            name: {key: figure.to_json() for key, figure in of.items()}
            for name, of in ablations.items()
        },
    }
    (project / JSON).parent.mkdir(parents=True, exist_ok=True)
    atomic_write(project / JSON, json.dumps(content, indent=1, allow_nan=False) + "\n")


def _row(figure: Figure) -> Row:
    ends = figure.interval or ()
    return {
        "figure": figure.says,
        "target": figure.target,
        "measured": "not measured" if figure.value is None else _shown(figure.value),
        "95 % interval": " to ".join(_shown(end) for end in ends),
        "of": figure.count,
        "met": {None: "", True: "yes", False: "**no**"}[figure.met],
    }


def _shown(value: float) -> str:
    # The median of an even number may lie half way to what was never found.
    return "never" if value >= 0.5 * FAR else f"{value:.3f}"


def confusion(cases: Sequence[Case], *, by_class: bool) -> dict[str, Counter[str]]:
    """What was named first, by what was true, of single effects that must be found."""
    found: dict[str, Counter[str]] = {}
    for case in cases:
        if case.answer.category == "single" and case.certain:
            true, named = case.true_effects[0], _named(case)
            if by_class:
                true = EFFECTS[true].group
                named = EFFECTS[named].group if named in EFFECTS else named
            found.setdefault(true, Counter())[named] += 1
    return found


def _named(case: Case) -> str:
    """The first effect named, or the verdict without one."""
    if case.causes:
        return alike(str(case.causes[0]["effect"]))
    return NOTHING if case.verdict == NO_GAP else case.verdict


def _classes(cases: Sequence[Case]) -> list[Row]:
    """Class named first (columns) by the true one (rows)."""
    groups = list(dict.fromkeys(kind.group for kind in EFFECTS.values()))
    named = (*groups, UNKNOWN, NOTHING, "error")
    found = confusion(cases, by_class=True)
    return [
        {"true": group, **{name: found[group][name] or "" for name in named}}
        for group in groups
        if group in found
    ]


def _confused(cases: Sequence[Case]) -> list[Row]:
    """Effects taken for others, most frequent first."""
    found = confusion(cases, by_class=False)
    wrong = Counter(
        {
            (true, named): count
            for true, row in found.items()
            for named, count in row.items()
            if named != true
        }
    )
    return [
        {
            "true": f"`{true}`",
            "named first": f"`{named}`",
            "sets": count,
            "near twins": "yes" if frozenset((true, named)) in NEAR_TWINS else "",
        }
        for (true, named), count in wrong.most_common(CONFUSED_MAX)
    ]


def _compared(name: str, found: Figures) -> Row:
    values = {key.replace("_", " "): found[key].value for key in COMPARED}
    return {
        "variant": name,
        **{key: "" if value is None else f"{value:.2f}" for key, value in values.items()},
    }
