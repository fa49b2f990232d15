"""Write docs/reference from the code, or say what is not up to date.

.venv/bin/python scripts/make_reference.py [--check]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from reference.commands import commands_page
from reference.files import files_page
from reference.interfaces import interfaces_page
from reference.launch_files import launch_page
from reference.made import all_made
from reference.parameters import parameters_page
from reference.topics import topics_page

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "reference"
INDEX = """\
# Reference

Generated from the code by `make reference`; a test checks that it is up to date.

- [Topics, services and actions](topics.md), with types and quality of service
- [Messages, services and actions](interfaces.md): definitions
- [Parameters](parameters.md) of every node, with units, bounds and defaults
- [Launch files](launch.md) and their arguments
- [Commands](commands.md) and their arguments
- [Files](files.md): configuration and results
"""


def pages() -> dict[str, str]:
    """Every page by its name."""
    made = all_made()
    return {
        "index.md": INDEX,
        "topics.md": topics_page(made),
        "interfaces.md": interfaces_page(ROOT),
        "parameters.md": parameters_page(made),
        "launch.md": launch_page(ROOT),
        "commands.md": commands_page(),
        "files.md": files_page(ROOT),
    }


def main() -> int:
    """Write the pages; with --check only compare, exit code 1 where one differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument(
        "--check", action="store_true", help="write nothing; fail where one differs"
    )
    check: bool = parser.parse_args().check
    FOLDER.mkdir(exist_ok=True)
    old = []
    for name, text in pages().items():
        file = FOLDER / name
        if not file.exists() or file.read_text() != text:
            old.append(str(file.relative_to(ROOT)))
            if not check:
                file.write_text(text)
    if check and old:
        print(f"not up to date: {', '.join(old)}; make reference", file=sys.stderr)
    return 1 if check and old else 0


if __name__ == "__main__":
    sys.exit(main())
