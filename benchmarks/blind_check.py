"""The blind check of the diagnosis: does it find causes that are withheld from it?

    .venv/bin/python benchmarks/blind_check.py [--seed N] [--small N] [--jobs N] [--baselines]

Draws sets with and without effects, seals what is true of them, diagnoses each once in processes
that cannot read the answers, and only then scores. Everything is taken up where it was left.
`enter` takes the answers of others, see benchmarks/blind/README.md. `unit-sizes` measures again how
large effects must be (benchmarks/blind/unit_sizes.json).
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from blind.cases import load_cases
from blind.composition import Mix
from blind.entries import compared, enter_baselines, enter_folder, recorded
from blind.generate import draw_round, make_sets
from blind.layout import OUT, ROOT, Round
from blind.score import score
from blind.submit import Submission, submit
from blind.unit_sizes import measure_units
from pages import markdown

STEPS = ("all", "generate", "diagnose", "score", "enter", "unit-sizes")


def main() -> None:
    """Do the steps asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("step", nargs="?", choices=STEPS, default="all")
    parser.add_argument("--seed", type=int, default=1, help="another seed is a fresh round")
    parser.add_argument("--small", type=int, metavar="N", help="the same mix in about N sets")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, help="folder of the round")
    parser.add_argument(
        "--ablations", type=int, default=12, metavar="N",
        help="single sets looked at again with something switched off; 0: no further looks",
    )  # fmt: skip
    parser.add_argument(
        "--baselines", action="store_true", help="diagnose by BIC and by F-tests, too"
    )
    parser.add_argument("--name", help="of who enters answers")
    parser.add_argument("--answers", type=Path, metavar="FOLDER", help="to enter, a file a set")
    parser.add_argument("--no-page", action="store_true", help="print the figures, write none")
    args = parser.parse_args()
    if args.step == "unit-sizes":
        measure_units(args.jobs)
        return
    size = "full" if args.small is None else str(args.small)
    place = Round(args.out or OUT / f"round_{args.seed}_{size}")
    if args.step == "enter":
        if args.name is None or args.answers is None:
            parser.error("enter needs --name and --answers")
        print(f"{enter_folder(place, args.name, args.answers)} answers entered")
        return
    if args.step in {"all", "generate"}:
        print(f"answers sealed: {draw_round(place, args.seed, Mix.of(args.small), args.jobs)}")
        make_sets(place, args.jobs)
    if args.step in {"all", "diagnose"}:
        diagnose(place, args.jobs)
        if args.baselines:
            enter_baselines(place, args.jobs)
    if args.step in {"all", "score"}:
        report(place, args)


def report(place: Round, args: argparse.Namespace) -> None:
    """Score, print the figures, and write them where that is asked for."""
    small = "" if args.small is None else f" --small {args.small}"
    baselines = " --baselines" if args.baselines else ""
    found = score(
        place,
        args.jobs,
        command=f'make blind ARGS="--seed {args.seed}{small}{baselines}"',
        ablations=args.ablations,
        project=None if args.no_page else ROOT,
    )
    for name, of in found.items():
        for key, figure in of.items():
            print(f"{name}, {key}: {figure.to_json()}")
    if rows := compared(place, load_cases(place)[0]):
        print(markdown(rows))


def diagnose(place: Round, jobs: int) -> None:
    """Submit every set that was made, once."""
    submit(place, [Submission(one, place.recorded(one)) for one in recorded(place)], jobs)


if __name__ == "__main__":
    main()
