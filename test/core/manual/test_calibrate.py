from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.manual.benches import (
    DEFAULT,
    PERFECT,
    ROOT,
    changed,
    nao,
    nao_shoe,
    odd_shoe,
    read_cells,
    read_shoe,
    some_law,
)
from core.simulation import worlds
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import (
    WrongShoeError,
    load_calibration,
    save_calibration,
)
from shoecal_core.manual.calibrate import (
    ManualCalibration,
    calibrate_cells,
    calibrate_manually,
    calibrate_shoe,
)
from shoecal_core.manual.loads import Load
from shoecal_core.manual.measurements import Measurements
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.workflows.simulated_manual import simulate_manual


def simulated(reality: PlantVariation, seed: int) -> ManualCalibration:
    cells, loads = simulate_manual(nao_shoe(), reality, seed, seed)
    return calibrate_manually(nao_shoe(), nao(), cells, loads)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_papers_table_on_the_simulated_shoe(seed: int) -> None:
    found = simulated(DEFAULT, seed)
    assert found.calibration.verdict == "PASS"
    for foot, after in zip(found.feet, (1.07e-3, 0.76e-3), strict=True):
        assert len(foot.loads.loads) == 126
        assert foot.grf.mean < 0.03
        assert 3e-3 < foot.known_cop.before.mean < 5e-3
        assert foot.known_cop.after.mean < after
        assert (
            foot.known_cop.after.mean
            < foot.known_cop.held_out.mean
            < 1.2 * foot.known_cop.after.mean
        )


def test_gains_and_offsets_are_those_that_were_drawn() -> None:
    shoe = nao_shoe()
    true = draw_shoes(DEFAULT, shoe, 4).parameters
    found = simulated(DEFAULT, 4).calibration
    np.testing.assert_allclose(found.parameters.gain, true.gain, rtol=1e-3)
    np.testing.assert_allclose(found.parameters.offset, true.offset, atol=0.03)
    assert found.covariance is not None
    error = np.concatenate((found.parameters.gain, found.parameters.offset))
    error -= np.concatenate((true.gain, true.offset))
    assert (np.abs(error) < 5.0 * np.sqrt(np.diag(found.covariance))).all()


def test_a_perfect_shoe_needs_no_correction() -> None:
    found = simulated(PERFECT, 1)
    for foot in found.feet:
        assert foot.grf.mean < 1e-3
        assert foot.known_cop.before.mean < 1e-4
        assert foot.known_cop.after.mean <= foot.known_cop.before.mean


def test_a_correction_that_does_not_help_is_not_kept() -> None:
    """Where all that is left is how the weights were placed, there is nothing to correct."""
    found = simulated(worlds.changed(PERFECT, rig__placement_error_std_m=6e-4), 1)
    assert found.calibration.corrections == ()
    for foot in found.feet:
        assert foot.known_cop.after == foot.known_cop.held_out == foot.known_cop.before
        np.testing.assert_array_equal(foot.known_cop.corrected, foot.loads.cop)


def test_what_the_calibration_says_of_itself() -> None:
    found = simulated(DEFAULT, 1)
    calibration = found.calibration
    assert calibration.source == "manual"
    assert calibration.id.startswith("manual-")
    assert (calibration.robot, calibration.robot_hash) == (nao().name, nao().digest)
    assert (calibration.shoe, calibration.shoe_hash) == ("nao_shoe", nao_shoe().digest)
    assert calibration.weight == nao().weight
    # The last load of the shoe: 2 x (1 + 126) of them, a second each.
    assert calibration.made_ns == 254_000_000_000
    assert [one.foot for one in calibration.corrections] == [0, 1]
    assert [fit.name for fit in found.cells] == list(nao_shoe().names)
    assert simulated(DEFAULT, 1).calibration.id == calibration.id
    assert simulated(DEFAULT, 2).calibration.id != calibration.id


def test_measuring_with_it_finds_the_weights() -> None:
    """The whole way: the calibration's own sensing on the rig's readings."""
    found = simulated(DEFAULT, 5)
    shoe = nao_shoe()
    _, loads = simulate_manual(shoe, DEFAULT, 5, 99)
    sensing = found.calibration.sensing(shoe)
    for foot in (0, 1):
        entries = [entry for entry in loads.of_foot(foot) if entry.load.place]
        readings = np.zeros((len(entries), len(shoe.names)))
        readings[:, shoe.of_foot(foot)] = [entry.mean for entry in entries]
        measured = sensing.measure(readings)
        own = found.feet[foot].loads
        np.testing.assert_allclose(measured.grf[:, foot], own.expected_force, atol=0.06)
        error = np.linalg.norm(measured.cop[:, foot] - own.expected_cop, axis=1)
        assert error.mean() < 1.1e-3
        # The other foot stands in the air; what it reads is that of no load at all.
        assert not measured.extrapolating[:, foot].all()


def test_the_file_holds_it_all(tmp_path: Path) -> None:
    found = simulated(DEFAULT, 1).calibration
    path = tmp_path / "calibration.yaml"
    save_calibration(found, path)
    again = load_calibration(path)
    assert again.id == found.id
    np.testing.assert_array_equal(again.parameters.offset, found.parameters.offset)
    for one, other in zip(again.corrections, found.corrections, strict=True):
        np.testing.assert_array_equal(one.x, other.x)
        np.testing.assert_array_equal(one.output_range, other.output_range)


def test_the_steps_apart_are_the_steps_together() -> None:
    shoe, robot = nao_shoe(), nao()
    cells, loads = simulate_manual(shoe, DEFAULT, 1, 1)
    first = calibrate_cells(shoe, robot, cells)
    assert first.calibration.verdict == "WARN"
    assert "load the shoe next" in first.calibration.reasons[0]
    assert first.calibration.corrections == ()
    second = calibrate_shoe(shoe, robot, first.calibration, loads)
    assert second.calibration.id == calibrate_manually(shoe, robot, cells, loads).calibration.id


def test_three_cells_and_six(tmp_path: Path) -> None:
    shoe = odd_shoe(tmp_path)
    robot = load_robot(ROOT / "test" / "data" / "robots" / "odd_biped.yaml", shoe)
    cells, loads = simulate_manual(shoe, DEFAULT, 1, 1)
    found = calibrate_manually(shoe, robot, cells, loads)
    assert found.calibration.verdict == "PASS"
    assert [one.channels for one in found.calibration.corrections] == [3, 6]
    for foot in found.feet:
        assert foot.grf.mean < 0.03
        assert foot.known_cop.after.mean < 1e-3 < foot.known_cop.before.mean


# ---- verdicts ---------------------------------------------------------------------------------


def verdict(
    law: ChannelParameters, cells: ChannelParameters | None = None, planned: int | None = None
) -> tuple[str, str]:
    """Of readings of a shoe with one law whose cells were measured as of another."""
    shoe, robot = nao_shoe(), nao()
    first = calibrate_cells(shoe, robot, read_cells(shoe, law if cells is None else cells))
    found = calibrate_shoe(shoe, robot, first.calibration, read_shoe(shoe, law), planned=planned)
    return found.calibration.verdict, "; ".join(found.calibration.reasons)


def test_all_is_well() -> None:
    assert verdict(some_law(nao_shoe())) == ("PASS", "every check passed")


def test_a_cell_wired_the_other_way() -> None:
    law = some_law(nao_shoe())
    other = ChannelParameters(law.gain * np.array([1, 1, -1, 1, 1, 1, 1, 1]), law.offset)
    found, reasons = verdict(other)
    assert found == "FAIL"
    assert "left/rear_left has the other sign" in reasons


def test_holes_counted_from_the_other_side() -> None:
    """A correction takes nearly all of it up, in the holes that were read."""
    shoe, law = nao_shoe(), some_law(nao_shoe())
    loads = read_shoe(shoe, law)
    other = str.maketrans("13", "31")
    mirrored = [
        dataclasses.replace(
            one, load=dataclasses.replace(one.load, place=one.load.place.translate(other))
        )
        if one.load.foot == 1
        else one
        for one in loads.entries
    ]
    first = calibrate_cells(shoe, nao(), read_cells(shoe, law))
    found = calibrate_shoe(
        shoe, nao(), first.calibration, dataclasses.replace(loads, entries=tuple(mirrored))
    )
    assert found.calibration.verdict == "FAIL"
    assert any(
        "CoP of the right shoe" in reason and "holes were counted from the right side" in reason
        for reason in found.calibration.reasons
    )


def test_a_cell_unlike_the_others() -> None:
    law = some_law(nao_shoe())
    weak = ChannelParameters(law.gain * np.array([1, 1, 1, 8, 1, 1, 1, 1]), law.offset)
    found, reasons = verdict(weak)
    assert found == "FAIL"
    assert "left/rear_right has gain" in reasons


def test_cells_that_changed_between_the_steps() -> None:
    law = some_law(nao_shoe())
    drifted = ChannelParameters(law.gain * 1.03, law.offset)
    found, reasons = verdict(law, cells=drifted)
    assert found == "FAIL"
    assert "GRF of the left shoe is 0.7" in reasons


def test_assembling_by_force() -> None:
    law = some_law(nao_shoe())
    shifted = ChannelParameters(law.gain, law.offset + 8.0)
    found, reasons = verdict(law, cells=shifted)
    assert found == "WARN"
    assert "assembling shifted the left shoe's offsets by up to 8.0 N" in reasons


def test_loads_left_out() -> None:
    found, reasons = verdict(some_law(nao_shoe()), planned=126)
    assert found == "WARN"
    assert "54 of 126 loads of the left shoe read" in reasons


# ---- refused ----------------------------------------------------------------------------------


def refused(loads: Measurements, *texts: str) -> None:
    shoe, robot = nao_shoe(), nao()
    first = calibrate_cells(shoe, robot, read_cells(shoe, some_law(shoe)))
    with pytest.raises(ShoecalError) as caught:
        calibrate_shoe(shoe, robot, first.calibration, loads)
    for text in texts:
        assert text in str(caught.value)


def test_another_weight_than_was_said() -> None:
    shoe = nao_shoe()
    loads = read_shoe(shoe, some_law(shoe))
    stood = next(entry for entry in loads.entries if entry.load == Load(0, "b2", 1.0))
    refused(
        changed(loads, Load(0, "b2", 2.5), mean=stood.mean),
        "left shoe, 2.5 kg in hole b2: weighs 1.00 kg",
        "read it again",
    )


def test_weights_of_another_unit_throughout() -> None:
    shoe = nao_shoe()
    loads = read_shoe(shoe, some_law(shoe))
    pounds = dataclasses.replace(
        loads,
        entries=tuple(
            dataclasses.replace(
                entry, load=dataclasses.replace(entry.load, mass=entry.load.mass / 0.4536)
            )
            for entry in loads.entries
        ),
    )
    refused(pounds, "left shoe: most loads weigh 0.4", "weights in another unit")


def test_a_weight_too_light_for_a_cop() -> None:
    shoe = nao_shoe()
    loads = read_shoe(shoe, some_law(shoe), (0.1, 1.0, 4.0))
    refused(loads, "left shoe, 0.1 kg in hole a1: too light for a CoP")


def test_a_shoe_that_was_not_loaded() -> None:
    shoe = nao_shoe()
    loads = read_shoe(shoe, some_law(shoe))
    bare = tuple(e for e in loads.entries if e.load.foot == 0 or not e.load.place)
    refused(dataclasses.replace(loads, entries=bare), "the right shoe was not loaded")


def test_readings_of_another_shoe(tmp_path: Path) -> None:
    shoe, robot = nao_shoe(), nao()
    odd = odd_shoe(tmp_path)
    with pytest.raises(ShoecalError, match="readings of shoe 'odd_shoe'"):
        calibrate_cells(shoe, robot, read_cells(odd, some_law(odd)))
    refused(read_shoe(odd, some_law(odd)), "readings of shoe 'odd_shoe'")


def test_cells_of_another_shoe(tmp_path: Path) -> None:
    shoe, robot = nao_shoe(), nao()
    odd = odd_shoe(tmp_path)
    loads = read_shoe(shoe, some_law(shoe))
    foreign = calibrate_cells(odd, robot, read_cells(odd, some_law(odd))).calibration
    with pytest.raises(WrongShoeError):
        calibrate_shoe(shoe, robot, foreign, loads)
    first = calibrate_cells(shoe, robot, read_cells(shoe, some_law(shoe))).calibration
    with pytest.raises(ShoecalError, match="another file of shoe 'nao_shoe'"):
        calibrate_shoe(shoe, robot, dataclasses.replace(first, shoe_hash="0" * 64), loads)


def test_the_expected_force_counts_weight_and_shoe() -> None:
    shoe = nao_shoe()
    loads = read_shoe(shoe, some_law(shoe))
    found = calibrate_manually(shoe, nao(), read_cells(shoe, some_law(shoe)), loads)
    own = found.feet[1].loads
    plates = shoe.plates[1]
    np.testing.assert_allclose(
        own.expected_force, (own.masses + plates.mass_above + plates.mass_below) * GRAVITY
    )
