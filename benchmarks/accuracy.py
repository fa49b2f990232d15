"""How accurate a calibration is, and whether what it states holds: several realities, fresh seeds.

    .venv/bin/python benchmarks/accuracy.py [--seeds 20] [--first 9] [--jobs 2] \\
        [--realities default other_laws as_stated noisy noisy_1n] [--motions paper standard] \\
        [--no-page]

Sessions are those of `accuracy_sessions.py`, made where they are missing; another run only
calibrates them anew: those of the standard set in the default reality with a manual calibration as
prior, too. Writes tables of docs/evidence/trust.md and the key `accuracy` of out/bench.json. Seeds
1 to 8 are there to develop with: by default none of them is in the table.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace

from accuracy_results import UNRECORDED, Result, measure
from accuracy_sessions import MOTIONS, REALITIES, cases, make
from accuracy_tables import tables
from pages import TRUST, markdown, record, write_section
from shoecal_core.workflows.many_jobs import over_cores


def main() -> None:
    """Make what is missing, calibrate, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=9)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--realities", nargs="+", default=REALITIES)
    parser.add_argument("--motions", nargs="+", choices=MOTIONS, default=MOTIONS)
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--no-page", action="store_true", help="print the tables only")
    args = parser.parse_args()
    wanted = cases(args.realities, args.motions, range(args.first, args.first + args.seeds))
    make(wanted, args.jobs)
    wanted += [replace(case, manual=True) for case in wanted if case.takes_manual]
    recorded = [case for case in wanted if not case.failed and not case.quiet.failed]
    results = [
        Result(case, UNRECORDED, case.failed or case.quiet.failed)
        for case in wanted
        if case not in recorded
    ]
    for done, (_, result) in enumerate(over_cores(measure, recorded, args.jobs), start=1):
        results.append(result)
        case = result.case
        print(
            f"{case.motions} {case.reality} {case.seed}: {result.verdict} {result.reason} "
            f"({done} of {len(recorded)})",
            flush=True,
        )
    found = tables(sorted(results, key=lambda one: wanted.index(one.case)))
    if args.no_page:
        print(json.dumps(found, indent=1))
        return
    record("accuracy", found)
    for name, rows in found.items():
        write_section(name, markdown(rows), TRUST)


if __name__ == "__main__":
    main()
