"""Run the demo with several seeds: the table of errors of docs/evidence/demo.md.

    .venv/bin/python benchmarks/demo_seeds.py [--seeds 10] [--out out/seeds]

A seed whose result stands already is not run again, so an interrupted run goes on.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pages import EVIDENCE, ROOT, Row, markdown, write_section

Result = dict[str, Any]
"""What the demo of one seed wrote to result.json."""

COLUMNS = {
    "weight off GRF [N]": ("modelled/grf_mae_n", "0.12 to 0.31"),
    "modelled CoP [mm]": ("modelled/cop_mae_mm", "2.0 to 3.0"),
    "guess GRF [N]": ("initial_guess/test/grf_mae_n", "7.5"),
    "guess CoP [mm]": ("initial_guess/test/cop_mae_mm", "23"),
    "train GRF [N]": ("self_calibration/train/grf_mae_n", ""),
    "train CoP [mm]": ("self_calibration/train/cop_mae_mm", ""),
    "test GRF [N]": ("self_calibration/test/grf_mae_n", "0.35"),
    "test CoP [mm]": ("self_calibration/test/cop_mae_mm", "2.8"),
    "left CoP [mm]": ("self_calibration/test/left_cop_mae_mm", ""),
    "right CoP [mm]": ("self_calibration/test/right_cop_mae_mm", ""),
    "total [s]": ("timing_s/total", ""),
}
"""Where a figure is in a result, and what the paper has on a real NAO."""
TARGETS = {"test GRF [N]": 0.35, "test CoP [mm]": 2.8}
"""Of the median."""
ALLOWED = 1.5
"""No seed may be worse than this many times the paper's figure."""


def main() -> int:
    """Run, write the table, and fail when the targets are missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "seeds")
    parser.add_argument("--doc", type=Path, default=EVIDENCE / "demo.md")
    args = parser.parse_args()
    found = {
        seed: _result(seed, args.out / f"seed_{seed:02d}") for seed in range(1, args.seeds + 1)
    }
    failed = [seed for seed, result in found.items() if result is None]
    results = [result for result in found.values() if result is not None]
    if failed:
        print(f"no result of seed(s) {failed}; the table is not written")
        return 1
    write_section("demo", markdown(_rows(results)), args.doc)
    return 0 if _met(results) else 1


def _result(seed: int, folder: Path) -> Result | None:
    path = folder / "result.json"
    if not path.is_file():
        print(f"seed {seed} …", flush=True)
        command = [str(Path(sys.executable).with_name("shoecal")), "demo"]
        done = subprocess.run([*command, "--seed", str(seed), "--out", str(folder)], check=False)
        if done.returncode != 0:
            return None
    found: Result = json.loads(path.read_text())
    return found


def _rows(results: Sequence[Result]) -> list[Row]:
    """A row a seed, their median, and the paper's figures."""
    found = {str(result["seed"]): figures(result) for result in results}
    medians = {name: statistics.median(row[name] for row in found.values()) for name in COLUMNS}
    return [
        *(
            {"seed": seed, **{name: f"{figure:.2f}" for name, figure in row.items()}}
            for seed, row in found.items()
        ),
        {"seed": "**median**", **{name: f"**{median:.2f}**" for name, median in medians.items()}},
        {
            "seed": "*paper*",
            **{name: f"*{paper}*" if paper else "" for name, (_, paper) in COLUMNS.items()},
        },
    ]


def figures(result: Result) -> dict[str, float]:
    """Errors of one seed, by column."""
    found = {}
    for name, (keys, _) in COLUMNS.items():
        value: Any = result
        for key in keys.split("/"):
            value = value[key]
        found[name] = float(value)
    return found


def _met(results: Sequence[Result]) -> bool:
    for name, limit in TARGETS.items():
        found = [figures(result)[name] for result in results]
        if statistics.median(found) > limit or max(found) > ALLOWED * limit:
            return False
    return True


if __name__ == "__main__":
    sys.exit(main())
