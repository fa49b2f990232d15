"""Tell every threshold of a diagnosis, and where its number comes from.

    .venv/bin/python benchmarks/diagnosis_thresholds.py

Writes a table of docs/evidence/diagnosis.md.
"""

from __future__ import annotations

from collections.abc import Mapping

from pages import EVIDENCE, Row, markdown, write_section
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.settings import describe

PAGE = EVIDENCE / "diagnosis.md"
TIME = "computing time"
ROBOTS = "robots as they are built"
MEANT = "what the answer is to mean"
TRIED = "development sessions"
LAST = "development sessions, and the blind round before"
ORIGINS: Mapping[str, str] = {
    "rate_hz": TIME,
    "walking_rate_hz": TRIED,
    "samples_max": TIME,
    "filter_rate_hz": TIME,
    "gain_std": ROBOTS,
    "nominal_gain_std": ROBOTS,
    "offset_std_n": ROBOTS,
    "lifted_m": ROBOTS,
    "parity_residual": TRIED,
    "model_error_rad": TRIED,
    "model_error_s": TRIED,
    "joint_zero_rad": ROBOTS,
    "causes_max": MEANT,
    "evidence_min": TRIED,
    "material": TRIED,
    "later_material": TRIED,
    "remainder_share": TRIED,
    "other_material": TRIED,
    "later_share": TRIED,
    "temper": LAST,
    "form_error": LAST,
    "outside": TRIED,
    "size_error": TRIED,
    "set_share": MEANT,
    "explained_from": MEANT,
    "unknown_below": TRIED,
    "unknown_from": LAST,
    "gap_from": LAST,
}
"""Of each setting."""


def thresholds() -> list[Row]:
    """A row a setting."""
    return [
        {
            "setting": f"`{one.name}`",
            "value": f"{one.default:g} {one.unit}".strip(),
            "meaning": one.doc,
            "from": ORIGINS[one.name],
        }
        for one in describe(DiagnosisSettings)
    ]


if __name__ == "__main__":
    write_section("thresholds", markdown(thresholds()), PAGE)
