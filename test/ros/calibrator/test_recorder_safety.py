from __future__ import annotations

import pytest

from shoecal_core.errors import ShoecalError
from shoecal_ros.calibrator.recorder import Recorder


def test_a_motion_that_nobody_recorded_is_no_run() -> None:
    recorder = Recorder(lambda: 1, 0.5)
    recorder.stand_by()
    recorder.stop()
    with pytest.raises(ShoecalError, match="done but not recorded"):
        recorder.finish()
