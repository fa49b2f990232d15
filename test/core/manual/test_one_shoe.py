"""A single shoe, and a sensor that feels the vertical force alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.manual.benches import nao, nao_shoe, read_cells, read_shoe, some_law
from core.shoe import mutations, shoes
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.manual.calibrate import (
    calibrate_cells,
    calibrate_manually,
    calibrate_shoe,
    of_shoe,
)
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters

LEFT_ONLY = (("feet", "right"), mutations.DELETE)
FORCE_ALONE = {"origin_m": [0, 0, 0.03], "axes": [{"axis": "fz", "polarity": 1}]}


def edited(folder: Path, *edits: tuple[tuple[str | int, ...], object]) -> Path:
    return mutations.write_edited(folder / "shoe.yaml", shoes.FILES["nao_shoe"], *edits)


def board(folder: Path) -> Shoe:
    """One plate on one vertical sensor, with one place for weights."""
    edits = (
        LEFT_ONLY,
        (("feet", "left", "cells"), mutations.DELETE),
        (("feet", "left", "six_axis"), FORCE_ALONE),
        (("feet", "left", "holes"), {"x_m": [0.0], "y_m": [0.0]}),
    )
    return load_shoe(edited(folder, *edits), partial=True)


def test_a_file_of_a_single_shoe(tmp_path: Path) -> None:
    """The same gains, offsets and correction as with the other one beside it."""
    shoe = load_shoe(edited(tmp_path, LEFT_ONLY), partial=True)
    assert (shoe.feet, shoe.gives_cop) == ((0,), (True, False))
    law = some_law(nao_shoe())
    own = ChannelParameters(law.gain[:4], law.offset[:4])
    both = calibrate_manually(
        nao_shoe(), nao(), read_cells(nao_shoe(), law), read_shoe(nao_shoe(), law)
    )
    alone = calibrate_manually(shoe, nao(), read_cells(shoe, own), read_shoe(shoe, own))
    assert alone.calibration.verdict == "PASS"
    assert alone.calibration.channels == nao_shoe().names[:4]
    np.testing.assert_allclose(alone.calibration.parameters.gain, law.gain[:4])
    np.testing.assert_allclose(
        alone.calibration.parameters.offset, both.calibration.parameters.offset[:4]
    )
    (foot,) = alone.feet
    assert foot.known_cop.after == both.feet[0].known_cop.after
    measured = Sensing(shoe, own).measure(np.zeros(4))
    assert measured.grf[1] == 0.0
    assert np.isnan(measured.cop[1]).all()


def test_one_foot_of_a_pair() -> None:
    """The cells of both may be known already."""
    left = nao_shoe().of_one_foot(0)
    law = some_law(nao_shoe())
    cells = calibrate_cells(nao_shoe(), nao(), read_cells(nao_shoe(), law)).calibration
    own = ChannelParameters(law.gain[:4], law.offset[:4])
    found = calibrate_shoe(left, nao(), of_shoe(cells, left), read_shoe(left, own))
    assert found.calibration.channels == left.names
    assert found.calibration.covariance is not None
    assert found.calibration.covariance.shape == (8, 8)
    with pytest.raises(ShoecalError, match="with channels left/front_left"):
        found.calibration.sensing(nao_shoe())


def test_a_vertical_force_alone(tmp_path: Path) -> None:
    """GRF, offsets of the assembled plate, and no CoP, which is said."""
    shoe = board(tmp_path)
    law = ChannelParameters(np.array([12.0]), np.array([3.0]))
    found = calibrate_manually(shoe, nao(), read_cells(shoe, law), read_shoe(shoe, law))
    calibration = found.calibration
    assert calibration.verdict == "WARN"
    assert calibration.reasons == (
        "WARN: the channels of the left shoe give a force alone: it has a GRF, but no CoP",
    )
    np.testing.assert_allclose(calibration.parameters.gain, law.gain)
    np.testing.assert_allclose(calibration.parameters.offset, law.offset, atol=1e-9)
    (foot,) = found.feet
    assert foot.cop is None
    assert foot.grf.mean < 1e-9
    with pytest.raises(ShoecalError, match="give a force alone, so no CoP"):
        _ = foot.known_cop
    sensing = calibration.sensing(shoe)
    measured = sensing.measure(np.array([[1.0], [2.0]]))
    below = shoe.plates[0].mass_below * 9.80665
    np.testing.assert_allclose(measured.grf[:, 0], [15.0 + below, 27.0 + below])
    assert np.isnan(measured.cop).all()
    left, _ = sensing.measure_instant([2.0])
    assert left.force == pytest.approx(27.0 + below)
    assert left.cop is None


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        (LEFT_ONLY, "feet.right: is missing; add it (a single shoe can be calibrated by `shoecal"),
        (
            (("feet", "left", "cells"), lambda cells: cells[:1]),
            "1 channels; a CoP needs at least three (fewer give a force alone, which `shoecal man",
        ),
    ],
)
def test_a_robot_that_calibrates_itself_needs_all(
    tmp_path: Path, edit: tuple[tuple[str | int, ...], object], problem: str
) -> None:
    with pytest.raises(FileError) as caught:
        load_shoe(edited(tmp_path, edit))
    assert problem in str(caught.value)


def test_a_foot_without_any_channel_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"feet\.left\.cells: is missing or empty"):
        load_shoe(edited(tmp_path, (("feet", "left", "cells"), [])), partial=True)
    with pytest.raises(FileError, match=r"feet\.left: is missing"):
        load_shoe(edited(tmp_path, LEFT_ONLY, (("feet", "left"), None)), partial=True)
