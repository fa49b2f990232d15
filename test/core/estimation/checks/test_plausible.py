from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.plausible import ImplausibleError, check_plausible
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workspace import config_dir

SHOE = load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")
COUNT = len(SHOE.names)
WEIGHT, WEIGHT_STD = 54.0, 0.3
MADE = Calibration(
    id="made",
    source="self",
    made_ns=10**18,
    robot="nao",
    shoe="nao_shoe",
    robot_hash="",
    shoe_hash="",
    channels=SHOE.names,
    parameters=ChannelParameters(np.where(SHOE.polarity > 0, 12.0, -12.0), np.zeros(COUNT)),
    covariance=0.01 * np.eye(2 * COUNT),
    corrections=(),
    weight=WEIGHT,
    time_offset=0.01,
    temperature=np.nan,
    verdict="PASS",
    reasons=("every check passed",),
)


def law(gain: float = 12.0, offset: float = 0.0) -> ChannelParameters:
    return ChannelParameters(np.where(SHOE.polarity > 0, gain, -gain), np.full(COUNT, offset))


def one(index: int, gain: float = 12.0, offset: float = 0.0) -> ChannelParameters:
    """One channel unlike the others."""
    found = law()
    found.gain[index] = gain * SHOE.polarity[index]
    found.offset[index] = offset
    return found


def correction(term: float, low: float) -> CopCorrection:
    box = np.array([[low, low], [1.0, 1.0]])
    ranges = np.array([np.zeros(4), np.ones(4)])
    return CopCorrection(0, np.full(8, term), np.zeros(8), box, ranges)


def test_what_robots_have_passes() -> None:
    check_plausible(MADE, SHOE, WEIGHT, WEIGHT_STD)
    counts = replace(MADE, parameters=law(gain=1.0), covariance=None, temperature=22.0)
    check_plausible(counts, SHOE, WEIGHT, WEIGHT_STD)
    check_plausible(replace(MADE, corrections=(correction(0.1, -1.0),)), SHOE, WEIGHT, WEIGHT_STD)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"parameters": law(gain=1e300)}, "N of a reading of left/front_left"),
        ({"parameters": law(gain=1.7e308)}, "N of a reading"),
        ({"parameters": law(offset=-1e300)}, "N of a reading"),
        ({"weight": 1e300}, "robot and shoes in use weigh 54 N"),
        ({"weight": 1e-9}, "robot and shoes in use weigh 54 N"),
        ({"weight": 3.0 * WEIGHT}, "robot and shoes in use weigh 54 N within 1.5 N"),
        ({"weight": WEIGHT + 1.6}, "robot and shoes in use weigh 54 N within 1.5 N"),
        ({"parameters": law(gain=-12.0)}, "gain that cannot be: left/front_left .*wrong sign"),
        ({"parameters": one(0, gain=12.0 * 6.0)}, "gain that cannot be: left/front_left has gain"),
        ({"parameters": one(1, offset=181.0)}, "offset of 181 N for left/front_right"),
        ({"covariance": 1e-9 * 0.01 * np.eye(2 * COUNT)}, "states GRF .* possible is 1e-05 to"),
        ({"covariance": 1e3 * 0.01 * np.eye(2 * COUNT)}, "states GRF .* possible is 1e-05 to 0.1"),
        ({"covariance": np.zeros((2 * COUNT, 2 * COUNT))}, "states GRF"),
        ({"time_offset": -11.0}, "time offset"),
        ({"temperature": 1e6}, "degC"),
        ({"made_ns": -1}, "1970"),
        ({"id": ""}, "id"),
        ({"source": "a\nb"}, "source"),
        ({"reasons": ("x",) * 1001}, "reasons"),
        ({"fitted_runs": ("x" * 2001,)}, "letters"),
        ({"reasons": ("fine", "two\nlines")}, "one line of text"),
        ({"reasons": ("\x1b[2Jgone",)}, "one line of text"),
        ({"fitted_runs": ("run\r",)}, "one line of text"),
        ({"shoe_hash": "\0"}, "one line of text"),
        ({"covariance": -np.eye(2 * COUNT)}, "covariance"),
        ({"covariance": np.eye(2 * COUNT) + np.eye(2 * COUNT, k=1)}, "covariance"),
        ({"covariance": 1e300 * np.eye(2 * COUNT)}, "uncertainties"),
        ({"corrections": (correction(1e9, -1.0),)}, "term"),
        ({"corrections": (correction(0.1, 2.0),)}, "range"),
        ({"corrections": (correction(0.1, -1.7e308),)}, "range"),
    ],
)
def test_what_no_robot_has_is_refused_by_name(changes: dict[str, object], told: str) -> None:
    with pytest.raises(ImplausibleError, match=told):
        check_plausible(replace(MADE, **changes), SHOE, WEIGHT, WEIGHT_STD)  # type: ignore[arg-type]
