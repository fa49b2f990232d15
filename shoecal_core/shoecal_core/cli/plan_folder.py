"""The folder of `shoecal plan`: what an earlier plan left there does not stay next to a new one."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

from shoecal_core.files import atomic_write, make_folder, system_error

PLAN = "plan.json"
_OWN = re.compile(r"motion_\d{3,}\.(csv|svg)|plan\.html")
"""Files that a plan may name; anything else is not ours to remove."""


class PlanFolder:
    """A folder that a plan is written into; made where there is none.

    Raises:
        FileError: when it cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        make_folder(folder)
        self._folder = folder
        self._earlier = _named(_read(folder / PLAN))

    def replace(self, plan: Mapping[str, object]) -> None:
        """Write `plan.json`; files that only the earlier one names are removed before."""
        for name in sorted(self._earlier - _named(plan)):
            try:
                (self._folder / name).unlink(missing_ok=True)
            except OSError as error:
                problem = "is of an earlier plan and cannot be removed"
                raise system_error(self._folder / name, error, problem, "remove it") from error
        atomic_write(self._folder / PLAN, json.dumps(plan, indent=1, allow_nan=False) + "\n")


def _read(file: Path) -> object:
    """Nothing where there is no plan that can be read."""
    try:
        return json.loads(file.read_bytes())
    except (OSError, ValueError):
        return None


def _named(plan: object) -> set[str]:
    """The plan's own files among all that it names."""
    if not isinstance(plan, Mapping):
        return set()
    rows = plan.get("motions")
    named = [plan.get("page")]
    for row in rows if isinstance(rows, list) else ():
        if isinstance(row, Mapping):
            named += [row.get("file"), row.get("picture")]
    return {name for name in named if isinstance(name, str) and _OWN.fullmatch(name)}
