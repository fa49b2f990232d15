"""Expected errors and observability, as a person reads it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.report import samples
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95, Assessment
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.assessment import (
    assessment_section,
    expected_keys,
    possible,
    source_pictures,
)
from shoecal_core.report.calibration.assessment_tables import carried, cure, rms, source_name
from shoecal_core.report.calibration.content import CalibrationReport
from shoecal_core.report.calibration.session_report import session_content
from shoecal_core.report.calibration.tables import channels_table
from shoecal_core.report.page import Group, Section
from shoecal_core.report.quantities import size
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import LeftOut, Screening
from shoecal_core.screening.verdict import Finding


@pytest.fixture(scope="module")
def swaying(session: Session, outcome: CalibrationOutcome) -> CalibrationReport:
    """Two training runs with joint angles, so the model's errors are known."""
    return session_content(session, outcome)


def assessed_in(content: CalibrationReport) -> Assessment:
    assert content.assessed is not None
    return content.assessed


def words(section: Section) -> str:
    """All texts of a section."""
    return " ".join([section.text, *(_words(group) for group in section.groups)])


def _words(group: Group) -> str:
    parts = [group.title, group.text]
    for picture in group.pictures:
        parts += [picture.title, picture.caption]
    for table in group.tables:
        parts += [table.title, *table.header, table.note, *(" ".join(row) for row in table.rows)]
    return " ".join(parts)


def test_expected_errors_are_told(swaying: CalibrationReport) -> None:
    """The same numbers as the terminal and the figures have."""
    assessed = assessed_in(swaying)
    shown = words(assessment_section(swaying, assessed))
    both, feet = assessed.expected_cop()
    for spread, cop in zip((assessed.both, *assessed.feet), (both, *feet.values()), strict=True):
        assert size(1e3 * cop, "mm") in shown
        assert size(rms(spread.grf), "N") in shown
    values = [key.value for key in expected_keys(assessed)]
    assert values[0] == size(1e3 * both, "mm")
    assert "expected CoP error, left foot" in [key.label for key in expected_keys(assessed)]


def test_error_sources_and_cures_are_named(swaying: CalibrationReport) -> None:
    assessed = assessed_in(swaying)
    assert carried(assessed)
    budget = assessed.budget
    assert budget is not None
    # Two runs leave gains open: as it is, knowing one source more would win nothing.
    best = next(one for one in budget.sources if np.isfinite(one.without).all())
    known = replace(best, without=0.5 * budget.total)
    sources = tuple(known if one is best else one for one in budget.sources)
    budget = replace(budget, sources=sources)
    assessed = replace(assessed, budget=budget)
    section = words(assessment_section(swaying, assessed))
    assert "What would help" in section
    assert source_name(best.effect) in section
    assert (cure(best.effect) or "") in section
    pictures = [one for one in source_pictures(assessed) if one.title in section]
    assert len(pictures) == 2
    for one in budget.sources[:2]:
        assert source_name(one.effect) in pictures[0].svg


def test_where_the_model_s_errors_are_not_known_it_is_said(content: CalibrationReport) -> None:
    assessed = assessed_in(content)
    assert not carried(assessed)
    shown = words(assessment_section(content, assessed))
    assert "the true errors are larger" in shown
    assert "What would help" not in shown
    assert "expected CoP error" not in shown
    assert all("known part" in key.label for key in expected_keys(assessed))


def test_what_was_left_open_and_what_to_add(content: CalibrationReport) -> None:
    """One training run alone leaves much open."""
    assessed = assessed_in(content)
    assert assessed.identifiability.weak
    shown = words(assessment_section(content, assessed))
    for weak in assessed.identifiability.weak:
        assert weak.words in shown
    assert assessed.support_to_add is not None
    assert str(assessed.support_to_add) in shown
    assert f"{assessed.identifiability.rank} of {possible(assessed)} patterns" in shown


def test_where_nothing_is_left_open(content: CalibrationReport) -> None:
    assessed = assessed_in(content)
    whole = replace(
        assessed, identifiability=replace(assessed.identifiability, weak=()), support_to_add=None
    )
    shown = words(assessment_section(content, whole))
    assert "All that double supports show" in shown
    assert "Left open by the data" not in shown
    assert "Double support to add" not in shown


def test_samples_left_out_are_counted_and_named(content: CalibrationReport) -> None:
    screening = Screening(
        findings=(Finding("WARN", "left/a gave spikes", Fault.SPIKE),),
        left_out=(
            LeftOut(1, Fault.SPIKE, 3, 0.0075, ((1.0, 1.0), (2.0, 2.1)), ("left/a",)),
            LeftOut(4, Fault.TOO_LITTLE, 400, 1.0, ((0.0, 9.0),)),
        ),
        samples={1: 400, 2: 400, 4: 400},
        kept={4: np.zeros(400, dtype=bool)},
    )
    assessed, faulty = assessed_in(content), replace(content, screening=screening)
    shown = words(assessment_section(faulty, assessed))
    assert "403 of 1200 samples do not count (33.6 %)" in shown
    assert "run 1 400 3 (0.8 %)" in shown
    assert "run 4 (all of it)" in shown
    assert "spike WARN left/a gave spikes" in shown
    assert "Samples left out, in time" in shown
    clean = replace(content, screening=Screening(samples={1: 400}))
    assert "Nothing: all 400 samples count" in words(assessment_section(clean, assessed))


def test_offsets_without_the_patterns_that_nobody_sees(
    text: str, swaying: CalibrationReport
) -> None:
    assert "It leaves out patterns" in text
    three = samples.content(samples.shoe_of(3), runs=1)
    assert "patterns" not in channels_table(three).note
    assert "look uncertain" in channels_table(replace(swaying, assessed=None)).note
    np.testing.assert_allclose(swaying.half_widths, NORMAL_95 * assessed_in(swaying).seen_std)
