"""Weights of the fit, each with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.settings import SettingError, setting
from shoecal_core.shoe.priors import PriorSettings

JOINT, PAPER = "joint", "paper"
"""Methods: with all that robot and shoes may have wrong, or gains and offsets alone."""


@dataclass(frozen=True)
class CalibrationSettings(PriorSettings):
    """How residuals are weighed against each other and against the initial guess.

    The paper's weights w_n, w_c, w_zeta are given as standard deviations: a residual counts
    by how many of them it is long. Samples within one correlation time carry one common
    model error, so together they count once.
    """

    method: str = setting(
        JOINT, "", "joint: gains and offsets with all that robot and shoes may have wrong; paper: "
        "initial guess, least squares and CoP correction (paper, VI)",
        choices=(JOINT, PAPER),
    )  # fmt: skip
    force_std_n: float = setting(0.3, "N", "how far the weight is off the true GRF", minimum=1e-6)
    cop_std_m: float = setting(
        0.0025, "m", "how far the modelled CoP is off the true CoP", minimum=1e-9
    )
    time_offset_std_s: float = setting(
        0.02, "s", "how far joints and readings are apart in time", minimum=0.0
    )
    model_error_rad: float = setting(
        0.002, "rad", "errors of the model that no error source explains, as a tilt of the soles; "
        "alike for correlation_s", minimum=1e-6,
    )  # fmt: skip
    correction_std_m: float = setting(
        0.001, "m", "of the method paper: size of one typical term of the CoP correction; 0: none",
        minimum=0.0,
    )  # fmt: skip
    fixed_below: float = setting(
        1.0,
        "",
        "a direction counts as fixed by the data when its uncertainty is below this share of the "
        "gains, and of each channel's even share of the weight",
        minimum=1e-6,
    )


def require_prior_counts(settings: CalibrationSettings) -> None:
    """Refuse a manual calibration under a method that would ignore it.

    Raises:
        SettingError: of a method without a prior.
    """
    if settings.method == PAPER:
        raise SettingError(
            "method",
            f"{PAPER} fits gains and offsets alone, so the manual calibration would be ignored: "
            f"calibrate with the method {JOINT}, or without the manual calibration (--manual of "
            "the command, manual_file of the node)",
        )
