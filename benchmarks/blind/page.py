"""The table: a section of docs/evidence/diagnosis.md, and out/blind.json."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from blind.cases import NO_GAP, UNKNOWN, Case
from blind.catalogue import EFFECTS, NEAR_TWINS, alike
from blind.draws import STRENGTHS
from blind.figures import FAR, Figure, rate
from blind.figures import figures as measured
from pages import table, write_section
from shoecal_core.files import atomic_write

PAGE = Path("docs/evidence/diagnosis.md")
FIGURE = Path("docs/figures/blind-detection.svg")
JSON = Path("out/blind.json")
"""Within the project."""
SECTION = "blind"
NOTHING = "nothing"
COMPARED = (
    "found", "false_alarms", "right_first", "right_among_three", "truth_in_set", "set_size",
    "exact_place", "known_called_unknown",
)  # fmt: skip
"""Figures of which selections are compared."""

BODY = """\
`{command}`: {sets}. Answers were drawn and sealed before the simulation, SHA-256
`{seal}`; each set was diagnosed once, by processes that cannot read
them. The noise floor (median of clean sets after a plain calibration) is {floor}; the
*gap* of a set is its larger ratio of CoP or GRF residual to it, measured by the generator on the
test runs with the noise of a usual cell. {failed}

{table}

Intervals of 95 %: exact for shares, else by resampling. Right effect, place and set refer to single
effects that were found, with a gap of at least 1.5; exact twins (`crosstalk` and `cell_position` of
its donor, a slip of either foot) count as one. A known weight is not part of the standard set.

![Share of single effects found, and named right, against their gap](../figures/{figure})

Detection by intended strength (the calibration absorbs some effects, and some are limited by what a
robot can stand):

{strength}

Class named first, for single effects with a gap of at least 1.5 (rows: true):

{classes}

Confused effects, most frequent first:

{confused}

{cones}{ablations}
"""
CONES = """\
By the friction cone of the set's engine. With MuJoCo's pyramids loaded feet chatter in some worlds:
readings leap by newtons while the robot moves, without any effect. That is an artefact of the
simulation that no set was meant to have; rounds drawn since have elliptic cones alone:

"""


def write_page(
    figures: Mapping[str, Figure],
    cases: Sequence[Case],
    ablations: Mapping[str, Mapping[str, Figure]],
    *,
    command: str,
    seal: str,
    floor: str,
    failed: str,
    page: Path,
) -> None:
    """Write the section.

    Args:
        figures: by key.
        cases: of the round.
        ablations: figures with something switched off, by what.
        command: that makes it.
        seal: of the answers.
        floor: in words.
        failed: sets that could not be made, in words.
        page: to write into.
    """
    counts = Counter(case.answer.category for case in cases)
    sets = ", ".join(f"{count} {name}" for name, count in counts.items())
    body = BODY.format(
        command=command, sets=f"{len(cases)} sets ({sets})", seal=seal, floor=floor,
        failed=failed, table=_table(figures), figure=FIGURE.name,
        strength=_strengths(cases), classes=_classes(cases), confused=_confused(cases),
        cones=_cones(cases), ablations=_ablations(ablations),
    )  # fmt: skip
    write_section(SECTION, body, page, "# Diagnosis\n")


def write_json(
    figures: Mapping[str, Figure],
    cases: Sequence[Case],
    ablations: Mapping[str, Mapping[str, Figure]],
    about: Mapping[str, object],
    file: Path,
) -> None:
    """Every figure under a plain key, the confusion matrix, and figures with something off."""
    told = {
        **about,
        "figures": {key: figure.to_json() for key, figure in figures.items()},
        "confusion": {
            true: dict(named) for true, named in sorted(confusion(cases, by_class=False).items())
        },
        "ablations": {
            name: {key: figure.to_json() for key, figure in of.items()}
            for name, of in ablations.items()
        },
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, json.dumps(told, indent=1, allow_nan=False) + "\n")


def confusion(cases: Sequence[Case], *, by_class: bool) -> dict[str, Counter[str]]:
    """What was named first, by what was true, of single effects with a gap."""
    found: dict[str, Counter[str]] = {}
    for case in cases:
        if case.answer.category == "single" and case.certain:
            true = case.true_effects[0]
            named = _named(case)
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


def _table(figures: Mapping[str, Figure]) -> str:
    rows = [("figure", "target", "measured", "95 % interval", "of", "met")]
    for figure in figures.values():
        share = figure.target is None or (figure.target.high or 1.0) <= 1.0
        met = figure.to_json()["met"]
        rows.append(
            (
                figure.says,
                "" if figure.target is None else str(figure.target),
                "not measured" if figure.value is None else _shown(figure.value, share=share),
                ""
                if figure.interval is None
                else " to ".join(_shown(end, share=share) for end in figure.interval),
                str(figure.count),
                {None: "", True: "yes", False: "**no**"}[met if isinstance(met, bool) else None],
            )
        )
    return table(rows)


def _shown(value: float, *, share: bool) -> str:
    if value >= FAR:
        return "never"
    return f"{value:.3f}" if share else f"{value:.3g}"


def _strengths(cases: Sequence[Case]) -> str:
    rows = [("strength", "sets", "median gap", "found", "right effect first")]
    for strength in STRENGTHS:
        of = [
            case
            for case in cases
            if case.answer.category == "single" and case.answer.truths[0].strength == strength
        ]
        if of:
            gaps = sorted(case.gap for case in of)
            found = rate("", [case.found for case in of])
            right = rate("", [case.first_right for case in of])
            rows.append(
                (f"{strength:g}", str(len(of)), f"{gaps[len(gaps) // 2]:.2f}",
                 f"{found.value:.2f}", f"{right.value:.2f}")
            )  # fmt: skip
    return table(rows)


def _classes(cases: Sequence[Case]) -> str:
    found = confusion(cases, by_class=True)
    groups = list(dict.fromkeys(kind.group for kind in EFFECTS.values()))
    named = [*groups, UNKNOWN, NOTHING, "error"]
    counted = [
        [group, *(str(found[group][name] or "") for name in named)]
        for group in groups
        if group in found
    ]
    return table([["true", *named], *counted])


def _confused(cases: Sequence[Case], most: int = 12) -> str:
    wrong = Counter(
        {
            (true, named): count
            for true, row in confusion(cases, by_class=False).items()
            for named, count in row.items()
            if named != true
        }
    )
    rows = [("true", "named first", "sets", "")]
    for (true, named), count in wrong.most_common(most):
        twins = "near twins" if frozenset((true, named)) in NEAR_TWINS else ""
        rows.append((f"`{true}`", f"`{named}`", str(count), twins))
    return table(rows) if len(rows) > 1 else "None was."


def _cones(cases: Sequence[Case]) -> str:
    of: dict[str, list[Case]] = {}
    for case in cases:
        of.setdefault(str(case.answer.world["engine"].get("cone", "")), []).append(case)
    if len(of) < 2:
        return ""
    return CONES + _compared({cone: measured(some) for cone, some in sorted(of.items())}) + "\n\n"


def _ablations(ablations: Mapping[str, Mapping[str, Figure]]) -> str:
    if not ablations:
        return ""
    return "The same sets with something left out:\n\n" + _compared(ablations)


def _compared(by_name: Mapping[str, Mapping[str, Figure]]) -> str:
    """Some figures of several selections, one a row."""
    rows = [("", *(key.replace("_", " ") for key in COMPARED))]
    for name, found in by_name.items():
        values = (found[key].value for key in COMPARED)
        rows.append((name, *("" if value is None else f"{value:.2f}" for value in values)))
    return table(rows)
