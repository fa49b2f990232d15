"""The report on a diagnosis: where the gap between model and reality lies, in pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shoecal_core.diagnosis.result import Diagnosis
from shoecal_core.report.diagnosis.answer import key_figures, run_text, verdict_of
from shoecal_core.report.diagnosis.figures import (
    quiet_signals,
    ranking_picture,
    share_picture,
    time_pictures,
)
from shoecal_core.report.diagnosis.places import place_pictures
from shoecal_core.report.diagnosis.tables import (
    alike_table,
    blind_spots_table,
    budget_table,
    causes_table,
    notes_table,
    shrink_table,
)
from shoecal_core.report.diagnosis.words import label_text, listed, motion_text, signal_text
from shoecal_core.report.html import write_page
from shoecal_core.report.page import Group, Page, Section, Table
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

SHOWN_SIGNALS = 3
"""Of the residuals in time, those that hold most of the gap; the others are folded."""


def write_diagnosis_report(
    diagnosis: Diagnosis,
    path: Path,
    *,
    robot: Robot,
    shoe: Shoe,
    provenance: Sequence[str] = (),
) -> None:
    """Write the report as one self-contained HTML file, whole or not at all.

    Args:
        diagnosis: what it shows; without `evidence` there are no pictures of samples.
        path: of the HTML file.
        robot, shoe: that the session was recorded with.
        provenance: lines that say where the session is from; see report/origin.py.

    Raises:
        FileError: when it cannot be written.
    """
    write_page(path, diagnosis_page(diagnosis, robot, shoe, provenance))


def diagnosis_page(
    diagnosis: Diagnosis, robot: Robot, shoe: Shoe, provenance: Sequence[str] = ()
) -> Page:
    """The report, ready to be rendered; the same diagnosis makes the same page."""
    sections = (
        _where(diagnosis, robot, shoe),
        _which(diagnosis),
        _alike(diagnosis),
        _unseen(diagnosis),
        _shrink(diagnosis),
        _next(diagnosis),
        _notes(diagnosis, robot, shoe),
    )
    train = listed([str(run) for run in diagnosis.train]) or "none"
    return Page(
        title=f"Where {diagnosis.robot} differs from its model",
        subtitle=(
            f"shoes {diagnosis.shoe} · fitted to runs: {train} · judged on {run_text(diagnosis)}"
        ),
        verdict=verdict_of(diagnosis),
        key_figures=key_figures(diagnosis),
        sections=tuple(section for section in sections if section is not None),
        provenance=tuple(provenance),
    )


def _where(diagnosis: Diagnosis, robot: Robot, shoe: Shoe) -> Section:
    evidence, shares = diagnosis.evidence, share_picture(diagnosis)
    groups = []
    if evidence is not None:
        pictures = place_pictures(diagnosis, evidence, robot, shoe)
        if shares is not None:
            pictures = (*pictures, shares)
        if pictures:
            groups.append(Group("On the feet", pictures=pictures))
        quiet = [signal_text(name) for name in quiet_signals(diagnosis, evidence)]
        text = "What is left of each signal after gains and offsets were fitted."
        if quiet:
            text += f" Looked at and not more than noise: {'; '.join(quiet)}."
        pictures = time_pictures(diagnosis, evidence)
        groups.append(Group("In time", text, pictures=pictures[:SHOWN_SIGNALS]))
        if more := pictures[SHOWN_SIGNALS:]:
            title = f"{len(more)} more signal{'s' if more[1:] else ''}"
            groups.append(Group(title, pictures=more, folded=True))
    elif shares is not None:
        groups.append(Group("How much of it where", pictures=(shares,)))
    made_of = budget_table(diagnosis)
    if made_of is not None:
        groups.append(Group(tables=(made_of,)))
    text = (
        "Model: what masses, lengths and joint angles say of GRF and CoP. Error: measured minus "
        "modelled, after gains and offsets of all channels were fitted."
    )
    if not groups:
        text = "Nothing that is more than noise was found in any signal."
    return Section("Where the gap lies", tuple(groups), text)


def _which(diagnosis: Diagnosis) -> Section | None:
    ranking = ranking_picture(diagnosis)
    pictures = () if ranking is None else (ranking,)
    tables = (causes_table(diagnosis),) if diagnosis.causes else ()
    if not pictures and not tables:
        return None
    return Section("Which cause", (Group(pictures=pictures, tables=tables),))


def _alike(diagnosis: Diagnosis) -> Section:
    table = alike_table(diagnosis)
    if table is None:
        text = "All effects that this session can show, it can also separate."
    else:
        text = "Effects that change what is measured in the same way, as far as this session goes."
    return _plain("What cannot be separated", table, text)


def _unseen(diagnosis: Diagnosis) -> Section:
    table = blind_spots_table(diagnosis)
    if table is None:
        text = "Every effect of the library would have shown in this session, had it been there."
    else:
        text = "That these were not found says nothing about whether they are there."
    return _plain("What this session could not show", table, text)


def _shrink(diagnosis: Diagnosis) -> Section | None:
    if not diagnosis.causes:
        return None
    text = (
        "Test runs took no part in any fit or ranking. The share of the gap that is gone there is "
        "what the explanation is worth."
        if diagnosis.test
        else "There is no test run: these are errors on the runs that were fitted, which flatters "
        "every explanation. Keep runs for a test to know what it is worth."
    )
    if any(cause.simulated is not None for cause in diagnosis.causes):
        text += (
            " In addition, the effect was given to a simulated robot, which replayed the same "
            "commanded motion: everything called simulated below comes from there."
        )
    group = Group(tables=(shrink_table(diagnosis),))
    title = "Before and after, on runs not used" if diagnosis.test else "Before and after"
    return Section(title, (group,), text)


def _next(diagnosis: Diagnosis) -> Section:
    motion = diagnosis.next_motion
    if motion is None:
        text = "No further motion would separate the candidates."
        if diagnosis.verdict == "unknown":
            text = "No motion is proposed: nothing in the library comes near enough to be tested."
        if len(diagnosis.ambiguity) > 1:
            text = "No motion was found that separates these candidates."
        return Section("What to run next", (), text)
    text = f"{motion_text(motion.motion).capitalize()} (motion “{motion.motion}”)."
    if motion.separates:
        text += f" It would separate: {listed([label_text(one) for one in motion.separates])}."
    return Section("What to run next", (), text)


def _notes(diagnosis: Diagnosis, robot: Robot, shoe: Shoe) -> Section:
    tables = [notes_table(diagnosis, robot, shoe)]
    if diagnosis.notes:
        rows = tuple((note,) for note in diagnosis.notes)
        tables.insert(0, Table("Missing or left out", ("",), rows))
    return Section("Notes", (Group("All notes", tables=tuple(tables), folded=True),))


def _plain(title: str, table: Table | None, text: str) -> Section:
    if table is None:
        return Section(title, (), text)
    count = f"{len(table.rows)} of them" if table.rows[1:] else "One of them"
    return Section(title, (Group(count, tables=(table,), folded=True),), text)
