"""Long work in a process of its own: the node goes on answering, and can stop it.

The child is started by module name, so nothing of the node's program is imported again; it
ends by itself, at once, when the node is gone.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar, cast

from shoecal_core.errors import ShoecalError

P = ParamSpec("P")
R = TypeVar("R")

NICE = 5
"""How far a child stands back behind the nodes; a planner still has to plan on a busy computer,
where the lowest priority (19) leaves it 1 % of a core."""
END_S = 5.0
"""How long a child may take to end once it is asked to."""

_PROGRESS, _RESULT, _ERROR = "progress", "result", "error"
_CHILD = "from shoecal_ros.common import worker; worker.main()"


class WorkerError(ShoecalError):
    """Work that failed in an unforeseen way."""


class Link:
    """The child's side: reports how far it is, and hears whether it shall stop."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._canceled = False

    def progress(self, value: object) -> None:
        """Report how far the work is."""
        self._connection.send((_PROGRESS, value))

    def canceled(self) -> bool:
        """Whether somebody asked to stop, or is gone."""
        try:
            if not self._canceled and self._connection.poll():
                self._connection.recv()
                self._canceled = True
        except (EOFError, OSError):
            self._canceled = True
        return self._canceled


class Work(Generic[R]):
    """Something a worker does.

    Attributes:
        progress: what it reported last, None before it did.
        done: whether it has ended, well or not.
        error: why it failed; None while it has not.
    """

    def __init__(self) -> None:
        self.progress: object = None
        self.done = False
        self._result: R | None = None
        self.error: ShoecalError | None = None

    def result(self) -> R:
        """What came out.

        Raises:
            ShoecalError: as the work raised it, or WorkerError.
        """
        if self.error is not None:
            raise self.error
        return cast(R, self._result)

    def finish(self, result: R | None, error: ShoecalError | None) -> None:
        """Note the end; the first one counts."""
        if not self.done:
            self._result, self.error = result, error
            self.done = True


class Worker:
    """One child process that does one thing after another.

    The child keeps what its functions cache, so that a second call is fast.

    Attributes:
        lost: why it can do nothing any more; None while it lives.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Start the child.

        Args:
            wake: called, from another thread, whenever something has come.
        """
        self._wake = wake
        self._work: Work[Any] | None = None
        self.lost: WorkerError | None = None
        self._connection, child = Pipe()
        # The node may be gone before the child has begun, and could not be found then.
        node = os.pidfd_open(os.getpid())
        self._process = subprocess.Popen(
            [sys.executable, "-c", _CHILD, str(child.fileno()), str(node)],
            pass_fds=[child.fileno(), node],
            stdin=subprocess.DEVNULL,
            process_group=0,  # with whatever processes it starts itself
        )
        child.close()
        os.close(node)
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def busy(self) -> bool:
        """Whether it is at work."""
        return self._work is not None and not self._work.done

    def do(
        self, function: Callable[Concatenate[Link, P], R], *args: P.args, **kwargs: P.kwargs
    ) -> Work[R]:
        """Start an importable function in the child.

        Raises:
            WorkerError: when it is still at work, or has died.
        """
        if self.busy:
            raise WorkerError("the worker is still busy; wait for it or cancel")
        self._work = work = Work[R]()
        try:
            self._connection.send((function, args, kwargs))
        except OSError:
            work.finish(None, self._died())
        return work

    def cancel(self) -> None:
        """Ask the work at hand to stop; it ends when it next looks."""
        if self.busy:
            # Where it has died the listener reports it.
            with contextlib.suppress(OSError):
                self._connection.send(None)

    def close(self) -> None:
        """End the child, whatever it is doing, and all processes it has started."""
        self._signal(signal.SIGTERM)
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()
        self._listener.join()
        self._connection.close()

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):  # it has ended by itself
            os.killpg(self._process.pid, number)

    def _listen(self) -> None:
        while True:
            try:
                kind, value = self._connection.recv()
            except (EOFError, OSError):
                break
            work = self._work
            if work is None:
                continue
            if kind == _PROGRESS:
                work.progress = value
            elif kind == _RESULT:
                work.finish(value, None)
            else:
                work.finish(None, value)
            self._wake()
        self.lost = self._died()
        if self._work is not None:
            self._work.finish(None, self.lost)
            self._wake()

    def _died(self) -> WorkerError:
        code = self._process.wait()
        return WorkerError(
            f"the worker process ended with code {code}; see its output above, check the memory "
            "and restart the node"
        )


def _serve(connection: Connection) -> None:
    """Do what comes, until the node is gone."""
    while True:
        try:
            request = connection.recv()
        except (EOFError, OSError):
            return
        if request is None:  # the cancelled work had just ended
            continue
        function, args, kwargs = request
        answer = _answer(function, Link(connection), args, kwargs)
        try:
            connection.send_bytes(answer)
        except OSError:
            return


def _answer(
    function: Callable[..., object], link: Link, args: tuple[Any, ...], kwargs: dict[str, Any]
) -> bytes:
    try:
        return pickle.dumps((_RESULT, function(link, *args, **kwargs)))
    except ShoecalError as error:
        return pickle.dumps((_ERROR, error))
    except Exception as error:  # noqa: BLE001 (whatever it is, the node must hear of it)
        traceback.print_exc()
        reported = (
            f"internal error in {function.__name__}: {type(error).__name__}: {error}; see the "
            "output of its node, and report it"
        )
        return pickle.dumps((_ERROR, WorkerError(reported)))


def _end_with(node: int) -> None:
    """Once the node has ended, killed perhaps, end amid any work, with all that it has started.

    Args:
        node: a descriptor of its process.
    """

    def wait() -> None:
        select.select([node], [], [])
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=wait, daemon=True, name="node").start()


def main() -> None:
    """The child process."""
    # An interrupt from the terminal is for the node, which ends this process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Live forces come first, on a small computer too; what it starts itself inherits that. Neither
    # does it share the priority of a node that runs in real time.
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    os.nice(NICE)
    _end_with(int(sys.argv[2]))
    _serve(Connection(int(sys.argv[1])))
