"""Arguments that several commands share."""

from __future__ import annotations

import argparse


def run_numbers(text: str) -> tuple[int, ...]:
    """Run numbers separated by commas: `1,2,5`."""
    try:
        return tuple(int(part) for part in text.split(",") if part.strip())
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}': expected run numbers separated by commas, for example 1,2,5"
        ) from None


def add_sets(parser: argparse.ArgumentParser) -> None:
    """`--train` and `--test`."""
    parser.add_argument(
        "--train",
        type=run_numbers,
        default=(),
        metavar="R,…",
        help="runs to fit (default: as the session marks them, else all)",
    )
    parser.add_argument(
        "--test", type=run_numbers, default=(), metavar="R,…", help="runs kept for the test"
    )
