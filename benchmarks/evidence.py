"""Renew the tables of docs/evidence, in about two hours on two cores.

    make evidence   (ARGS="demo_seeds paper": these only)

Runs one benchmark after the other, short ones first, each with fewer draws than it has by default:
where a table is to say more, run its own `make` target. Results of other code are forgotten; those
of the same commit stay, so an interrupted run goes on. Ends with 0 only if every benchmark does.
Tables of robots' published files and of recorded sets need those, and are left: `BY_HAND`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from pages import ROOT, version

ORDER = {
    "live_path": "",
    "public_robots": "",
    "demo_seeds": "--seeds 5",
    "planner_speed": "--nao 100",
    "own_steps": "--supports 10 --seeds 2",
    "planned_motions": "--count 10",
    "clean_sessions": "--seeds 5",
    "closed_loop": "--seeds 1",
    "accuracy": "--seeds 2",
    "repeats": "",
    "paper": "",
    # Draws and clean sessions are those of the population that `paper` leaves.
    "caught_faults": "--draws 3 --clean 10",
    "blind_check": "--small 56 --ablations 0 --baselines",
    "faults": "--fresh --share 0.005",
}
"""Benchmarks and their arguments."""

BY_HAND = {"published_robots", "real_robots"}
"""Benchmarks that need a folder of what others have published."""

OUT = ROOT / "out"
RESULTS = (
    "population", "accuracy", "seeds", "own_steps", "planned_motions", "robots", "trust", "blind",
)  # fmt: skip
"""Folders of `OUT` in which benchmarks find what they have measured before."""


def main() -> int:
    """Forget what other code has measured, and run the benchmarks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of: {', '.join(ORDER)}")
    names = parser.parse_args().names or list(ORDER)
    if unknown := sorted(set(names) - set(ORDER)):
        parser.error(f"no benchmark of these: {', '.join(unknown)}")
    forget_older(OUT, version())
    failed = [name for name in names if not runs(name)]
    print("\n".join(f"failed: {name}" for name in failed) or "all tables are renewed")
    return 1 if failed else 0


def forget_older(out: Path, now: str) -> None:
    """Remove results of another version than `now`, which tables would take for their own."""
    mark = out / "evidence.txt"
    if not mark.is_file() or mark.read_text() != now:
        for folder in RESULTS:
            shutil.rmtree(out / folder, ignore_errors=True)
        out.mkdir(parents=True, exist_ok=True)
        mark.write_text(now)


def runs(name: str) -> bool:
    """Whether a benchmark ends well; its figures are those of one thread a process."""
    print(f"{name} {ORDER[name]}", flush=True)
    command = [sys.executable, str(ROOT / "benchmarks" / f"{name}.py"), *ORDER[name].split()]
    one_thread = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(command, env=one_thread, check=False).returncode == 0


if __name__ == "__main__":
    sys.exit(main())
