from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording import messages
from shoecal_core.recording.series import series

FloatArray = NDArray[np.float64]
NAMES = ("left_knee", "r", "head")
stamps_of = st.lists(st.integers(0, 2**31 * 10**9 - 1), max_size=5).map(
    lambda found: np.array(found, dtype=np.int64)
)


def joints(stamp: int, numbers: FloatArray) -> bytes:
    return messages.joint_state(stamp, NAMES, numbers[:3], numbers[3:])


def inertial(stamp: int, numbers: FloatArray) -> bytes:
    return messages.imu(stamp, "base_link", numbers[:4], numbers[4:7], numbers[7:])


@pytest.mark.parametrize(("one", "count"), [(joints, 6), (inertial, 10)])
@given(data=st.data())
def test_a_series_is_what_single_messages_are(one, count: int, data: st.DataObject) -> None:  # type: ignore[no-untyped-def]
    stamps = data.draw(stamps_of)
    values = data.draw(hnp.arrays(np.float64, (len(stamps), count)))
    made = series(one, stamps, values)
    assert made == [one(int(at), row) for at, row in zip(stamps, values, strict=True)]


def test_wrong_calls_are_refused() -> None:
    one = np.array([1], dtype=np.int64)
    with pytest.raises(ShapeError, match="values"):
        series(joints, one, np.zeros((2, 6)))
    with pytest.raises(ShoecalError, match="must be 0 to 2"):
        series(joints, -one, np.zeros((1, 6)))
    with pytest.raises(ShoecalError, match="each number once"):
        series(lambda stamp, numbers: joints(stamp, 0.0 * numbers), one, np.zeros((1, 6)))
