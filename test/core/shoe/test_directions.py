from __future__ import annotations

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.shoe.directions import describe_direction

NAO = shoes.shoe("nao_shoe")
X, Y = NAO.positions.T
LEFT = (NAO.foot == 0).astype(float)
BOTH, AGAINST = np.ones(8), 2.0 * LEFT - 1.0
FRONT, SIDE = np.sign(X), np.where(NAO.foot == 0, np.sign(Y - 0.0055), np.sign(Y + 0.0055))
TWIST = FRONT * SIDE
NOTHING = np.zeros(8)


@pytest.mark.parametrize(
    ("gains", "offsets", "words"),
    [
        (NOTHING, AGAINST, "the difference of the offsets between the left and the right foot"),
        (BOTH, NOTHING, "the common level of all gains"),
        (NOTHING, LEFT, "the level of the offsets of the left foot"),
        (FRONT, NOTHING, "the gains of the front against the rear cells in both feet"),
        (
            NOTHING,
            SIDE * AGAINST,
            "the offsets of the left against the right cells in opposite ways in the two feet",
        ),
        (
            NOTHING,
            TWIST * (1.0 - LEFT),
            "offsets that cancel within the right foot",
        ),
    ],
)
def test_pure_patterns_have_their_name(gains: FloatArray, offsets: FloatArray, words: str) -> None:
    assert describe_direction(NAO, np.concatenate((gains, offsets))) == words
    assert describe_direction(NAO, -0.1 * np.concatenate((gains, offsets))) == words


def test_the_largest_part_comes_first() -> None:
    mixed = np.concatenate((0.8 * BOTH, AGAINST + 0.1 * TWIST))
    assert describe_direction(NAO, mixed) == (
        "the difference of the offsets between the left and the right foot with "
        "the common level of all gains"
    )


def test_axes_of_a_sensor_are_named_one_by_one() -> None:
    shoe = shoes.made([*shoes.six_axis(0, (0.0, 0.0, 0.05)), *shoes.six_axis(1, (0.0, 0.0, 0.05))])
    direction = np.zeros(20)
    direction[[0, 13]] = (0.5, -1.0)
    assert describe_direction(shoe, direction) == "the offset of left/mx"
    direction[0] = 1.0
    assert describe_direction(shoe, direction) == "the gain of left/fx with the offset of left/mx"


def test_another_length_is_refused() -> None:
    with pytest.raises(ShapeError, match="direction"):
        describe_direction(NAO, np.zeros(8))
