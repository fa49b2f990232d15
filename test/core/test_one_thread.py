"""Programs keep linear algebra on one thread, unless the user says otherwise."""

import os
import subprocess
import sys

import pytest


@pytest.mark.parametrize(("asked", "expected"), [(None, 1), ("2", 2)])
def test_threads_of_the_command_line(asked: str | None, expected: int) -> None:
    environment = {key: value for key, value in os.environ.items() if "_NUM_THREADS" not in key}
    if asked is not None:
        environment["OPENBLAS_NUM_THREADS"] = asked
    script = (
        "import os, shoecal_core.cli, numpy as np\n"
        "np.linalg.inv(np.eye(500))\n"
        "print(os.environ['OPENBLAS_NUM_THREADS'], len(os.listdir('/proc/self/task')))"
    )
    told = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert told.stdout.split() == [str(expected)] * 2
