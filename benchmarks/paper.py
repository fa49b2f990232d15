"""The paper's evaluation on simulated robots: docs/evidence/paper.md, its figures, out/paper.json.

    .venv/bin/python benchmarks/paper.py [--seeds 10] [--population out/population]

Manual calibration, both assumptions and all stages of the self-calibration, robot by robot. The
sessions are those of `population.py`, made where they do not stand yet. Fails where a target is
missed.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pages import markdown, write_section
from paper_figures import write_figures
from paper_reproduction import Paper, reproduce
from paper_tables import tables, to_json
from paper_targets import missed
from population import OUT, ROOT, different_robots, sessions
from shoecal_core.files import atomic_write


def main() -> int:
    """Reproduce, write, and tell what was missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--population", type=Path, default=OUT)
    parser.add_argument("--json", type=Path, default=ROOT / "out" / "paper.json")
    parser.add_argument("--doc", type=Path, default=ROOT / "docs" / "evidence" / "paper.md")
    args = parser.parse_args()
    robots = []
    for member, session in sessions(different_robots(args.seeds, args.population)):
        print(f"robot {member.seed} of {args.seeds}", flush=True)
        robots.append(reproduce(member, session))
    return write(Paper(robots), args.json, args.doc)


def write(paper: Paper, figures: Path, doc: Path) -> int:
    """Write everything; 0 where every target is met."""
    write_figures(paper, doc.parent.parent / "figures")
    for name, rows in tables(paper).items():
        write_section(name, markdown(rows), doc)
    figures.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(figures, json.dumps(to_json(paper), indent=1, allow_nan=False) + "\n")
    print(f"{doc}\n{figures}")
    wrong = missed(paper)
    for target in wrong:
        print(f"missed: {target}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
