"""A process that diagnoses sets and can reach nothing of the answers.

Started by `submit` in a Python that does not see the benchmarks' folder; every line it reads is a
command of `shoecal`, every line it writes what came of it. A hook that cannot be taken out again
forbids it, and what it starts by forking, to open anything sealed and to import the generator.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import sys
from pathlib import Path

FORBIDDEN = ("blind", "blind_check")
"""Modules that the diagnosis may not see."""
_LOOKS = frozenset(("open", "os.listdir", "os.scandir", "os.chdir", "os.link", "os.symlink",
                    "os.rename", "os.chmod", "shutil.copyfile", "shutil.move"))  # fmt: skip


def shut_out(sealed: Path) -> None:
    """Forbid this process everything below a folder, and the generator's modules."""
    barred = os.path.realpath(sealed)

    def hook(event: str, args: tuple[object, ...]) -> None:
        if event == "import" and str(args[0]).split(".")[0] in FORBIDDEN:
            raise PermissionError(errno.EPERM, f"the diagnosis imports {args[0]}")
        if event not in _LOOKS:
            return
        for path in args:
            if not isinstance(path, str | bytes | os.PathLike):
                continue
            real = os.path.realpath(os.fsdecode(path))
            if os.path.commonpath([real, barred]) == barred:
                raise PermissionError(errno.EACCES, "is sealed", real)

    sys.addaudithook(hook)


def main() -> None:
    """Serve until nothing more is asked."""
    shut_out(Path(sys.argv[1]))
    from shoecal_core.cli import main as shoecal  # noqa: PLC0415 - its imports are watched as well

    told = sys.stdout
    for line in sys.stdin:
        said, error = io.StringIO(), ""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            try:
                code = shoecal(json.loads(line))
            except SystemExit as end:
                code = 2 if not isinstance(end.code, int) else end.code
            except Exception as broken:  # noqa: BLE001 - a traceback is an answer too: a wrong one
                code, error = 3, f"{type(broken).__name__}: {broken}"
        error = error or said.getvalue().strip()[-500:]
        print(json.dumps({"code": code, "error": error if code else ""}), file=told, flush=True)


if __name__ == "__main__":
    main()
