"""Answers of others to a round's sets: each set once, scored as the diagnosis is."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from blind.baselines import baselines
from blind.cases import UNKNOWN, Case, variant_cases
from blind.figures import Figure, rate
from blind.layout import Round, set_name
from blind.processes import over
from blind.submit import Ledger, Submission
from pages import Row
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write

OURS = "shoecal"
ANSWER = {"verdict", "causes", "ambiguity_set", "where"}
CAUSE = {"effect", "class", "location", "probability", "size"}
"""Keys of an answer and of each of its causes."""
_ENTRY = "entry_"


def enter(place: Round, name: str, answers: Mapping[int, bytes]) -> None:
    """Keep somebody's answers, by number of the set, as JSON; see README.md for what they say.

    Raises:
        ShoecalError: for a second answer to a set.
    """
    ledger = Ledger(place.ledger)
    for number, answer in answers.items():
        one = Submission(number, place.recorded(number), f"{_ENTRY}{name}")
        file = place.diagnosis(number, one.variant)
        file.parent.mkdir(parents=True, exist_ok=True)
        ledger.enter(one, answer)
        atomic_write(file, answer)


def enter_folder(place: Round, name: str, folder: Path) -> int:
    """Keep the answers of a folder, one `set_0001.json` a set; how many there are."""
    numbers = [number for number in recorded(place) if _file(folder, number).is_file()]
    if not numbers:
        raise ShoecalError(f"{folder}: holds no answer to any set of {place.folder}")
    for number in numbers:
        _check(_file(folder, number))
    enter(place, name, {number: _file(folder, number).read_bytes() for number in numbers})
    return len(numbers)


def enter_baselines(place: Round, jobs: int) -> None:
    """Let the baselines answer what they have not answered yet."""
    known = Ledger(place.ledger).entries()
    todo = [one for one in recorded(place) if f"{one} {_ENTRY}BIC" not in known]
    said = over(baselines, [place.recorded(one) for one in todo], jobs)
    for number, answers in zip(todo, said, strict=True):
        for name, answer in answers.items():
            enter(place, name, {number: answer})
        print(f"baselines: {set_name(number)}", flush=True)


def recorded(place: Round) -> list[int]:
    """Numbers of the sets that were made."""
    folders = sorted(place.recorded(0).parent.glob("set_*"))
    return [int(folder.name.removeprefix("set_")) for folder in folders]


def compared(place: Round, cases: Sequence[Case]) -> list[Row]:
    """Figures of the diagnosis and of every entry, one column each; none without entries."""
    folders = sorted(place.diagnosis(0).parents[1].glob(f"{_ENTRY}*"))
    names = [folder.name.removeprefix(_ENTRY) for folder in folders]
    of = {OURS: list(cases)}
    of |= {name: _answered(place, cases, name) for name in names}
    columns = {name: figures(own) for name, own in of.items()}
    if not names:
        return []
    return [
        {"figure": says, **{name: _shown(column[says]) for name, column in columns.items()}}
        for says in columns[OURS]
    ]


def _answered(place: Round, cases: Sequence[Case], name: str) -> list[Case]:
    """The same sets as an entry answers them; who leaves one out has found nothing in it."""
    given = {case.answer.number: case for case in variant_cases(place, cases, f"{_ENTRY}{name}")}
    return [given.get(one.answer.number, dataclasses.replace(one, said=None)) for one in cases]


def figures(cases: Sequence[Case]) -> dict[str, Figure]:
    """What can be asked of any answer, whatever the robot was, by what it says."""
    gaps = [case for case in cases if case.answer.category != "clean" and case.certain]
    single = [case for case in gaps if case.answer.category == "single"]
    unknown = [case for case in gaps if case.answer.category == "unknown"]
    clean = [case for case in cases if case.answer.category == "clean"]
    hits = {
        "found": [case.found for case in gaps],
        "right effect first, of single ones": [case.first_right for case in single],
        "right effect among three, of single ones": [
            case.true_effects[0] in case.effects[:3] for case in single
        ],
        "wrong effect first, of single ones": [
            bool(case.causes) and not case.first_right for case in single
        ],
        "healthy robots with a cause named": [bool(case.causes) for case in clean],
        "unknown effects called unknown": [case.verdict == UNKNOWN for case in unknown],
    }
    return {says: rate(says, each) for says, each in hits.items()}


def _check(file: Path) -> None:
    """Refuse an answer that could not be scored, before it counts."""
    try:
        said = json.loads(file.read_text())
    except ValueError as error:
        raise ShoecalError(f"{file}: no JSON: {error}") from error
    causes = said.get("causes", []) if isinstance(said, dict) else []
    for what, keys in ((said, ANSWER), *((cause, CAUSE) for cause in causes)):
        if not isinstance(what, dict) or not keys <= what.keys():
            raise ShoecalError(f"{file}: needs {', '.join(sorted(keys))}; got {what!r:.200}")


def _shown(figure: Figure) -> str:
    if figure.value is None or figure.interval is None:
        return "not measured"
    low, high = figure.interval
    return f"{figure.value:.2f} ({low:.2f} to {high:.2f}) of {figure.count}"


def _file(folder: Path, number: int) -> Path:
    return folder / f"{set_name(number)}.json"
