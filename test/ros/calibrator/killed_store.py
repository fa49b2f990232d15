"""Changes a store in child processes, each of which kills itself one file operation later.

    python killed_store.py FOLDER

Leaves one folder a cut in FOLDER and prints their names in order; the last one was not cut.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from ros.bodies import calibration, nao, nao_shoe
from shoecal_ros.calibrator.calibration_store import CalibrationStore

T0, SECOND = 10**18, 10**9
OPERATIONS = {"open", "os.rename", "os.remove", "os.mkdir"}


def change(folder: Path) -> None:
    """Four changes."""
    store = CalibrationStore(folder, nao(), nao_shoe())
    store.load(T0)
    for count, name in enumerate(("one", "two", "three"), start=1):
        store.apply(calibration(nao(), nao_shoe(), name), T0 + count * SECOND)
    store.apply(store.one_before()[0], T0 + 4 * SECOND)


def kill_at(folder: Path, cut: int) -> None:
    """Die before the operation of this number on anything in a folder."""
    seen = 0

    def audit(event: str, arguments: tuple[object, ...]) -> None:
        nonlocal seen
        if event not in OPERATIONS or not str(arguments[0]).startswith(str(folder)):
            return
        if seen == cut:
            os.kill(os.getpid(), signal.SIGKILL)
        seen += 1

    sys.addaudithook(audit)


def main() -> None:
    """Cut later and later, until nothing is left to be cut."""
    root = Path(sys.argv[1])
    nao_shoe(), nao()
    cut, killed = 0, True
    while killed:
        folder = root / f"cut_{cut:03d}"
        folder.mkdir()
        child = os.fork()
        if child == 0:
            kill_at(folder, cut)
            change(folder)
            os._exit(0)
        status = os.waitpid(child, 0)[1]
        killed = os.WIFSIGNALED(status)
        assert killed or os.waitstatus_to_exitcode(status) == 0
        print(folder.name)
        cut += 1


if __name__ == "__main__":
    main()
