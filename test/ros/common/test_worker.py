from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import pytest

from ros.common import worker_tasks
from shoecal_core.errors import NameNotFoundError
from shoecal_ros.common.worker import Work, Worker, WorkerError

T = TypeVar("T")
TIMEOUT_S = 120.0


class Waiter:
    """Wakes up a test as a worker wakes up its node."""

    def __init__(self) -> None:
        self._event = threading.Event()

    def wake(self) -> None:
        self._event.set()

    def until(self, condition: Callable[[], object]) -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while not condition():
            assert time.monotonic() < deadline
            self._event.wait(TIMEOUT_S)
            self._event.clear()

    def result(self, work: Work[T]) -> T:
        self.until(lambda: work.done)
        return work.result()


@pytest.fixture
def waiter() -> Waiter:
    return Waiter()


@pytest.fixture
def worker(waiter: Waiter, monkeypatch: pytest.MonkeyPatch) -> Iterator[Worker]:
    # The child imports the tests' own tasks.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    worker = Worker(waiter.wake)
    yield worker
    worker.close()


def is_alive(pid: object) -> bool:
    """Whether a process runs; one that nobody has buried yet does not."""
    state = subprocess.run(
        ["ps", "-o", "state=", "-p", str(pid)], capture_output=True, text=True, check=False
    ).stdout.strip()
    return state not in {"", "Z"}


def wait_for_end(pid: object) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while is_alive(pid):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_one_thing_after_another(worker: Worker, waiter: Waiter) -> None:
    work = worker.do(worker_tasks.add, 2, other=3)
    assert waiter.result(work) == 5
    assert work.progress == "adding"
    assert [waiter.result(worker.do(worker_tasks.count)) for _ in range(3)] == [1, 2, 3]


def test_errors_come_back_as_they_were(worker: Worker, waiter: Waiter) -> None:
    with pytest.raises(NameNotFoundError, match="dance") as caught:
        waiter.result(worker.do(worker_tasks.refuse))
    assert caught.value.available == ("landmarks",)
    with pytest.raises(WorkerError, match="stumble: ValueError: nobody foresaw this"):
        waiter.result(worker.do(worker_tasks.stumble))
    with pytest.raises(WorkerError, match="unspeakable"):
        waiter.result(worker.do(worker_tasks.unspeakable))
    assert waiter.result(worker.do(worker_tasks.add, 1, 1)) == 2


def test_it_stops_when_told(worker: Worker, waiter: Waiter) -> None:
    work = worker.do(worker_tasks.wait_for_end)
    waiter.until(lambda: work.progress)
    assert worker.busy
    with pytest.raises(WorkerError, match="busy"):
        worker.do(worker_tasks.add, 1, 1)
    worker.cancel()
    assert waiter.result(work) == "canceled"
    worker.cancel()  # too late: nothing is at work
    assert waiter.result(worker.do(worker_tasks.add, 1, 1)) == 2


def test_a_child_that_dies_is_told(worker: Worker, waiter: Waiter) -> None:
    assert worker.lost is None
    with pytest.raises(WorkerError, match="code -9"):
        waiter.result(worker.do(worker_tasks.die))
    assert worker.lost is not None
    assert "restart the node" in str(worker.lost)
    with pytest.raises(WorkerError, match="code -9"):
        waiter.result(worker.do(worker_tasks.add, 1, 1))


def test_closing_ends_whatever_it_does(waiter: Waiter, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    worker = Worker(waiter.wake)
    work = worker.do(worker_tasks.hang)
    waiter.until(lambda: work.progress)
    worker.close()
    assert not is_alive(work.progress)
    with pytest.raises(WorkerError):
        work.result()


def test_closing_ends_what_its_work_has_started(
    waiter: Waiter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    worker = Worker(waiter.wake)
    work = worker.do(worker_tasks.hang_together)
    waiter.until(lambda: work.progress)
    worker.close()
    wait_for_end(work.progress)


@pytest.mark.parametrize("task", ["wait_for_end", "hang", "hang_together"])
def test_the_child_ends_when_its_node_is_killed(task: str) -> None:
    program = (
        "import sys, time\n"
        "from ros.common import worker_tasks\n"
        "from shoecal_ros.common.worker import Worker\n"
        f"work = Worker(lambda: None).do(worker_tasks.{task})\n"
        "while not work.progress: time.sleep(0.01)\n"
        "print(work.progress, flush=True)\n"
        "time.sleep(1000)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=environment
    ) as node:
        assert node.stdout is not None
        child = node.stdout.readline().strip()
        assert is_alive(child)
        node.kill()
    wait_for_end(child)


def test_the_child_ends_when_its_node_is_killed_before_it_has_begun() -> None:
    program = (
        "import os, signal\n"
        "from ros.common import worker_tasks\n"
        "from shoecal_ros.common.worker import Worker\n"
        "Worker(lambda: None).do(worker_tasks.hang_silently)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    # The child has the same output: that ends with it.
    subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, check=False, env=environment, timeout=TIMEOUT_S,
    )  # fmt: skip
