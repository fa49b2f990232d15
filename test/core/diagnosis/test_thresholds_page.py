"""The page tells the thresholds that the code has."""

from __future__ import annotations

from diagnosis_thresholds import ORIGINS, PAGE, thresholds
from pages import markdown
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.settings import describe


def test_every_threshold_has_an_origin() -> None:
    assert set(ORIGINS) == {one.name for one in describe(DiagnosisSettings)}


def test_the_page_is_up_to_date() -> None:
    told = PAGE.read_text().partition("<!-- thresholds -->")[2].partition("<!-- /thresholds -->")[0]
    assert told.strip() == markdown(thresholds()), "run benchmarks/diagnosis_thresholds.py"
