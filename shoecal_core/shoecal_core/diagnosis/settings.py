"""Thresholds of a diagnosis, each with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.settings import setting


@dataclass(frozen=True)
class DiagnosisSettings(SignalSettings):
    """How samples are made and when something counts as found."""

    causes_max: int = setting(4, "", "effects in one explanation at most", minimum=1, maximum=12)
    evidence_min: float = setting(
        25.0, "", "an effect is needed when the data are more probable with it by this, as a "
        "logarithm, beyond what its prior costs", minimum=0.0,
    )  # fmt: skip
    material: float = setting(
        0.8,
        "",
        "it matters when it explains errors of CoP or GRF by this share of their floor",
        minimum=0.0,
    )
    later_material: float = setting(
        1.25, "", "the same of a further effect: remainders of one that the library has in nearly "
        "its form are smaller", minimum=0.0,
    )  # fmt: skip
    remainder_share: float = setting(
        0.25, "", "a further effect that adds more than this share of the evidence found so far "
        "is no remainder of it", minimum=0.0,
    )  # fmt: skip
    other_material: float = setting(
        0.6, "", "share of their floor that such an effect must explain", minimum=0.0
    )
    later_share: float = setting(
        0.06, "", "a further effect must add this share of the evidence found so far: an effect "
        "whose form the library has only nearly leaves a remainder of its own", minimum=0.0,
    )  # fmt: skip
    temper: float = setting(
        0.08, "", "logarithms of probabilities count by this share: hypotheses are only models",
        minimum=1e-3, maximum=1.0,
    )  # fmt: skip
    form_error: float = setting(
        0.04, "", "and by less where there is much evidence: a cause whose form the library has "
        "only nearly is this share of the evidence off", minimum=0.0,
    )  # fmt: skip
    outside: float = setting(
        0.04, "", "probability that a cause is none of the library's, however well one fits",
        minimum=0.0, maximum=0.5,
    )  # fmt: skip
    size_error: float = setting(
        0.08, "", "how far sizes may be off, over themselves, because reality has an effect in "
        "another form than the library", minimum=0.0,
    )  # fmt: skip
    set_share: float = setting(
        0.95, "", "probability that a set of explanations which cannot be told apart holds",
        minimum=0.5, maximum=0.999,
    )  # fmt: skip
    explained_from: float = setting(
        0.6, "", "part of the excess that must go for a gap to count as explained", minimum=0.0
    )
    unknown_below: float = setting(
        0.4, "", "less than this part explained: the cause is unknown", minimum=0.0
    )
    unknown_from: float = setting(
        1.5,
        "",
        "the same for a gap of which nothing in the library explains anything",
        minimum=1.0,
    )
    gap_from: float = setting(
        1.45, "", "errors of CoP or GRF over their floor from which there is a gap", minimum=1.0
    )
