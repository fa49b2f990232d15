from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.load_cases import double_support_outputs, single_support_outputs
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

FORCE = 54.0
PLACES = np.array([[0.0, 0.0], [0.05, -0.02], [-0.03, -0.1]])
supports = st.builds(
    DoubleSupport, st.floats(-0.1, 0.1), st.floats(-0.2, -0.1), st.floats(-0.6, 0.6)
)


def sensing(shoe: Shoe) -> Sensing:
    count = len(shoe.channels)
    return Sensing(shoe, ChannelParameters(np.ones(count), np.zeros(count)), minimum_force=0.0)


@given(supports, st.sampled_from(shoes.NAMES))
def test_both_feet_carry_the_load_where_it_is(support: DoubleSupport, name: str) -> None:
    shoe = shoes.shoe(name)
    got = sensing(shoe).measure(double_support_outputs(shoe, support, FORCE, PLACES))
    np.testing.assert_allclose(got.total_grf, FORCE)


def test_the_cop_of_both_feet_is_the_place(shoe: Shoe) -> None:
    support = DoubleSupport(0.02, -0.12, 0.3)
    between = np.array([[0.02, -0.03], [0.03, -0.06], [0.01, -0.09]])
    got = sensing(shoe).measure(double_support_outputs(shoe, support, FORCE, between))
    assert (got.grf > 0.0).all()
    np.testing.assert_allclose(got.combined_cop(support), between, atol=1e-12)


def test_equal_springs_share_a_central_load_alike() -> None:
    corners = np.array([(0.05, 0.03), (0.05, -0.03), (-0.05, 0.03), (-0.05, -0.03)])
    shoe = shoes.made([*shoes.cells(0, corners), *shoes.cells(1, corners)])
    outputs = single_support_outputs(shoe, 1, 20.0, np.zeros((1, 2)))
    np.testing.assert_allclose(outputs[0], [0.0] * 4 + [5.0] * 4, atol=1e-12)


def test_a_hanging_foot_reads_zero(shoe: Shoe) -> None:
    outputs: FloatArray = single_support_outputs(shoe, 0, FORCE, PLACES)
    got = sensing(shoe).measure(outputs)
    np.testing.assert_allclose(got.grf, [[FORCE, 0.0]] * len(PLACES), atol=1e-12)
    np.testing.assert_allclose(got.cop[:, 0], PLACES, atol=1e-12)
