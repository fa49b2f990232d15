"""What an earlier plan left in a folder: its own files go, all others stay."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from shoecal_core.cli.plan_command import PlanFolder
from shoecal_core.errors import FileError


def plan(*numbers: int, page: str | None = "plan.html") -> dict[str, object]:
    rows = [{"file": f"motion_{n:03d}.csv", "picture": f"motion_{n:03d}.svg"} for n in numbers]
    return {"page": page, "motions": rows}


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def test_files_of_an_earlier_plan_only(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    outside = tmp_path / "motion_001.csv"
    earlier = plan(1, 2)
    strangers = {"file": "../motion_001.csv", "picture": "notes.txt"}
    earlier["motions"] = [*earlier["motions"], strangers, "odd"]  # type: ignore[misc]
    PlanFolder(folder).replace(earlier)
    for name in ("motion_001.csv", "motion_001.svg", "motion_002.csv", "motion_009.csv"):
        (folder / name).touch()
    for file in (outside, folder / "notes.txt", folder / "plan.html"):
        file.touch()
    later = PlanFolder(folder)
    assert "motion_002.csv" in names(folder)
    later.replace(plan(1))
    stay = {"plan.json", "motion_001.csv", "motion_001.svg", "motion_009.csv", "notes.txt"}
    assert names(folder) == stay | {"plan.html"}
    assert json.loads((folder / "plan.json").read_text()) == plan(1)
    PlanFolder(folder).replace(plan(page=None))
    assert names(folder) == {"plan.json", "motion_009.csv", "notes.txt"}
    assert outside.exists()


@pytest.mark.parametrize("text", ["", "[1", "[]", '{"motions": 1}', '{"page": [2]}', "\0\xff"])
def test_what_is_no_plan_names_nothing(tmp_path: Path, text: str) -> None:
    (tmp_path / "plan.json").write_bytes(text.encode("latin-1"))
    (tmp_path / "motion_001.csv").touch()
    PlanFolder(tmp_path).replace(plan())
    assert "motion_001.csv" in names(tmp_path)


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot be made"):
        PlanFolder(tmp_path / "file" / "out")
