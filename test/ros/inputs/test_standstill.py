from __future__ import annotations

import numpy as np
import pytest

from ros.bodies import calibration, nao, nao_shoe, parameters, readings
from ros.instants import COUNT, batch, joined
from shoecal_ros.inputs.joining import Joined
from shoecal_ros.inputs.standstill import Standstill


def test_it_is_done_when_it_has_lasted() -> None:
    standstill = Standstill(0.5)
    standstill.take_readings([joined(step, 1.0 + 0.1 * step) for step in range(5)])
    assert not standstill.done
    standstill.take_readings([joined(5, 1.5)])
    assert not standstill.done  # no joints
    for value in (0.1, 0.3):
        standstill.take_joints(batch(value))
    assert standstill.done
    np.testing.assert_allclose(standstill.readings, 1.25)
    np.testing.assert_allclose(standstill.angles, 0.2)
    standstill.restart()
    assert not standstill.done


def test_a_reading_counts_once() -> None:
    standstill = Standstill(0.5, least=3)
    standstill.take_joints(batch())
    for value in (1.0, 5.0):
        standstill.take_readings([joined(0, value)])
    standstill.take_readings([joined(9, 2.0)])
    assert not standstill.done
    standstill.take_readings([joined(10, 3.0)])
    assert standstill.done
    np.testing.assert_allclose(standstill.readings, 2.0)


def test_bad_readings_are_named() -> None:
    standstill = Standstill(0.5)
    standstill.take_readings([joined(0), joined(1, bad=3)])
    assert standstill.bad == {3}


def test_unrest_is_that_of_the_force() -> None:
    shoe = nao_shoe()
    sensing = calibration(nao(), shoe).sensing(shoe)
    standstill = Standstill(0.5)
    for step, force in enumerate((-3.0, 3.0) * 5):
        outputs = np.full(COUNT, 5.0)
        outputs[2] += force
        reported = readings(shoe, parameters(shoe), outputs)
        standstill.take_readings(
            [Joined(step, reported, np.zeros(COUNT, np.uint8), np.ones(COUNT, dtype=np.bool_))]
        )
    assert standstill.unrest(sensing) == pytest.approx(3.0)
