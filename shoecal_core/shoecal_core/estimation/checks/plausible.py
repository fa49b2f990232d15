"""Is a calibration one that any robot could have? Checked of calibrations from other programs."""

from __future__ import annotations

import math

import numpy as np

from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.usable import check_gains
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import by_parameters

LARGEST_OUTPUT_N = 1e9
"""Of a channel at the ends of its range; counts with a gain of 1 N stay far below."""
WEIGHT_STDS, WEIGHT_SHARE = 5.0, 0.01
"""The weight is that of the robot file within so many of its standard uncertainties, or this share:
another weight has scaled the gains alike."""
GRF_STD_SHARES = (1e-5, 0.1)
"""Of the weight: stated standard deviation of GRF with the weight evenly on all channels. Weights
on the shoe give 6e-5 (`shoecal manual`), and no load cell repeats to less than 1e-5; less sure
than a tenth says nothing."""
SPANS_BEYOND = 1.0
"""Spans of the converter's range by which a reading without any force may be beyond it."""
LARGEST_TIME_OFFSET_S = 10.0
TEMPERATURES_DEGC = (-100.0, 1000.0)
LARGEST_TERM = 1e6
"""Of a CoP correction and of the covariance's standard deviations."""
LONGEST_TEXT, MOST_TEXTS = 2000, 1000
"""Letters; reasons, or runs."""
_ROUNDING = 1e-6


class ImplausibleError(ShoecalError):
    """A calibration with a value that no robot has."""


def check_plausible(calibration: Calibration, shoe: Shoe, weight: float, weight_std: float) -> None:
    """Refuse values that are numbers, but no calibration's.

    Args:
        calibration: of this shoe.
        shoe: with the channels' ranges.
        weight: of the robot with its shoes [N].
        weight_std: its standard uncertainty [N].

    Raises:
        ImplausibleError: names the first such value and its bound.
    """
    _check_texts(calibration)
    _check_numbers(calibration, weight, weight_std)
    _check_outputs(calibration, shoe)
    _check_gains(calibration, shoe)
    _check_covariance(calibration)
    _check_stated(calibration, shoe, weight)
    for correction in calibration.corrections:
        if max(np.abs(correction.x).max(), np.abs(correction.y).max()) > LARGEST_TERM:
            raise _refused(calibration, f"has a CoP correction with a term above {LARGEST_TERM:g}")
        for low, high in (correction.cop_range, correction.output_range):
            if (low > high).any() or max(-low.min(), high.max()) > LARGEST_OUTPUT_N:
                raise _refused(calibration, "has a CoP correction with a range that is none")


def _check_texts(calibration: Calibration) -> None:
    lists = (calibration.reasons, calibration.fitted_runs)
    if any(len(texts) > MOST_TEXTS for texts in lists):
        raise _refused(calibration, f"has more than {MOST_TEXTS} reasons or runs")
    names = {
        "id": calibration.id,
        "source": calibration.source,
        "robot": calibration.robot,
        "shoe": calibration.shoe,
    }
    for name, text in names.items():
        if not text or not text.isprintable():
            raise _refused(calibration, f"has a {name} that is empty or not one line of text")
    hashes = (calibration.robot_hash, calibration.shoe_hash)
    for text in (*names.values(), *hashes, *calibration.reasons, *calibration.fitted_runs):
        if len(text) > LONGEST_TEXT:
            raise _refused(calibration, f"has a text of more than {LONGEST_TEXT} letters")
        if not text.isprintable():
            raise _refused(
                calibration, "has a reason, a run or a hash that is not one line of text"
            )


def _check_numbers(calibration: Calibration, weight: float, weight_std: float) -> None:
    bound = max(WEIGHT_STDS * weight_std, WEIGHT_SHARE * weight)
    if not abs(calibration.weight - weight) <= bound:
        raise _refused(
            calibration,
            f"is of a robot of {calibration.weight:.4g} N; robot and shoes in use weigh "
            f"{weight:.4g} N within {bound:.2g} N",
        )
    if abs(calibration.time_offset) > LARGEST_TIME_OFFSET_S:
        raise _refused(calibration, f"has a time offset above {LARGEST_TIME_OFFSET_S:g} s")
    low, high = TEMPERATURES_DEGC
    if not (np.isnan(calibration.temperature) or low <= calibration.temperature <= high):
        raise _refused(calibration, f"was made at a temperature beyond {low:g} to {high:g} degC")
    if calibration.made_ns < 0:
        raise _refused(calibration, "was made before 1970")


def _check_outputs(calibration: Calibration, shoe: Shoe) -> None:
    ends = np.array([[channel.lowest, channel.highest] for channel in shoe.channels])
    reach = np.abs(np.where(np.isfinite(ends), ends, 0.0)).max(axis=1)
    law = calibration.parameters
    with np.errstate(over="ignore"):
        outputs = np.abs(law.gain) * np.maximum(reach, 1.0) + np.abs(law.offset)
    worst = int(np.argmax(outputs))
    if not outputs[worst] <= LARGEST_OUTPUT_N:
        raise _refused(
            calibration,
            f"makes {outputs[worst]:.3g} N of a reading of {calibration.channels[worst]}; at most "
            f"{LARGEST_OUTPUT_N:g}",
        )
    span = np.ptp(ends, axis=1)
    unloaded = -law.offset / law.gain
    low, high = ends[:, 0] - SPANS_BEYOND * span, ends[:, 1] + SPANS_BEYOND * span
    beyond = np.flatnonzero(np.isfinite(span) & ((unloaded < low) | (unloaded > high)))
    for index in beyond[:1]:
        raise _refused(
            calibration,
            f"has an offset of {law.offset[index]:g} N for {calibration.channels[index]}, which "
            f"then reads {unloaded[index]:.3g} without force; its converter gives "
            f"{ends[index, 0]:g} to {ends[index, 1]:g}",
        )


def _check_gains(calibration: Calibration, shoe: Shoe) -> None:
    for finding in check_gains(shoe, shoe.polarity, calibration.parameters)[:1]:
        raise _refused(calibration, f"has a gain that cannot be: {finding.reason}")


def _check_covariance(calibration: Calibration) -> None:
    for covariance in (calibration.joint_covariance, calibration.support_covariance):
        if covariance is None:
            continue
        scale = float(np.abs(covariance).max())
        if scale > LARGEST_TERM**2:
            raise _refused(calibration, f"has uncertainties above {LARGEST_TERM:g}")
        rounding = _ROUNDING * scale
        if np.abs(covariance - covariance.T).max() > rounding or (
            np.linalg.eigvalsh(covariance).min() < -rounding
        ):
            raise _refused(
                calibration, "has a covariance that is none: symmetric, nothing negative"
            )


def _check_stated(calibration: Calibration, shoe: Shoe, weight: float) -> None:
    """What a covariance states of GRF is neither absurdly small nor absurdly large."""
    if calibration.covariance is None:
        return
    vertical = calibration.calibrated(shoe).columns[:, 0]
    law = calibration.parameters
    evenly = weight / np.count_nonzero(vertical)
    readings = (np.where(vertical != 0.0, evenly, 0.0) - law.offset) / law.gain
    (jacobian,) = by_parameters(vertical[None], readings)
    share = math.sqrt(max(0.0, jacobian @ calibration.covariance @ jacobian)) / weight
    low, high = GRF_STD_SHARES
    if not low <= share <= high:
        raise _refused(
            calibration,
            f"states GRF to a standard deviation of {share:.2g} of the weight; possible is "
            f"{low:g} to {high:g}, and no covariance where it is unknown",
        )


def _refused(calibration: Calibration, why: str) -> ImplausibleError:
    name = calibration.id[:40] if calibration.id.isprintable() else ""
    return ImplausibleError(f"calibration '{name}' {why}; correct its sender, or calibrate again")
