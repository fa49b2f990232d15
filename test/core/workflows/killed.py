"""Work of which one job ends its process."""

from __future__ import annotations

import os
import signal

DEADLY = 2


def square(job: int) -> int:
    """The job's square; one of them is killed, as by a system out of memory."""
    if job == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    return job * job


def nothing(job: int) -> int:
    """Stands for a job that was lost."""
    return -job
