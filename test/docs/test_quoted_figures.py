"""Figures that README and the pages for users quote are those of the generated tables."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from docs.pages import ROOT

EVIDENCE = ROOT / "docs" / "evidence"
README = (ROOT / "README.md").read_text()
MOTIONS = ROOT / "docs" / "how-to" / "choose-motions.md"


def cells(line: str) -> list[str]:
    return [cell.strip(" *") for cell in line.strip("|").split("|")]


def row(page: str, start: str) -> list[str]:
    """The first row of a table that begins so."""
    lines = (EVIDENCE / page).read_text().splitlines()
    return cells(next(line for line in lines if line.startswith(f"| {start}")))


def test_readme_quotes_the_demo() -> None:
    head, values = row("demo.md", "seed")[1:], row("demo.md", "**median**")[1:]
    median = dict(zip(head, map(float, values), strict=True))
    lines = (EVIDENCE / "demo.md").read_text().splitlines()
    seeds = sum(bool(re.match(r"\| \d+ \|", line)) for line in lines)
    assert f"(median of {seeds} robots)" in README
    before, after = median["guess CoP [mm]"], median["test CoP [mm]"]
    assert f"CoP {before:.1f} → {after:.1f} mm" in README
    before, after = median["guess GRF [N]"], median["test GRF [N]"]
    assert f"GRF {before:.1f} → {after:.2f} N" in README
    assert f"| {median['total [s]']:.0f} s (median of {seeds}" in README


def test_readme_quotes_the_blind_test() -> None:
    def share(figure: str) -> str:
        return f"{float(row('diagnosis.md', figure)[2]):.0%}".replace("%", " %")

    assert f"It sees {share('found, where')} of the causes" in README
    assert f"Of those the right one comes first in {share('right effect first')}" in README
    assert f"of two causes it finds both in {share('both of two found')}" in README
    right = row("diagnosis.md", "right effect first")
    assert f"(of {right[4]})" in README
    wrong, singles = row("diagnosis.md", "wrong effect first, of single ones")[1].split(" of ")
    named = round(float(wrong.split(" ")[0]) * int(singles))
    assert f"a wrong cause comes first in {named} of {singles} recordings" in README
    alarms = row("diagnosis.md", "healthy robots with a cause")
    assert float(alarms[2]) == 0.0
    assert f"no cause named on {alarms[4]} healthy robots" in README


def test_readme_quotes_the_real_recordings() -> None:
    found = row("real-robots.md", "stepping + walking a | walking b")
    before, after = (float(found[column].split(" ± ")[0]) for column in (2, 4))
    assert f"GRF error in a held-out walk {before:.0f} → {after:.0f} N" in README


def test_readme_counts_the_descriptions_that_go_the_whole_way() -> None:
    table = (EVIDENCE / "robots.md").read_text().split("<!-- published -->")[1]
    rows = [cells(line) for line in table.split("<!-- /published -->")[0].splitlines()]
    shown = [
        f"{sum(one[5] == 'yes' for one in of)} of {len(of)} {kind}"
        for kind in ("URDF", "MJCF")
        if (of := [one for one in rows if len(one) > 5 and one[1] == kind])
    ]
    assert f"[{' and '.join(shown)} descriptions](docs/evidence/robots.md" in README


def quoted() -> Iterator[tuple[str, Path]]:
    """Each accuracy of the page on motions, with the page of its table."""
    target = EVIDENCE
    for line in MOTIONS.read_text().splitlines():
        parts = cells(line)
        if len(parts) == 4:
            link = re.search(r"\((\.\./evidence/[\w-]+\.md)", parts[3])
            target = (MOTIONS.parent / link[1]).resolve() if link else target
            for figure in re.findall(r"\d+\.\d", parts[2]):
                yield figure, target


def test_accuracy_of_motions_is_in_the_tables() -> None:
    found = list(quoted())
    assert len(found) > 5
    for figure, page in found:
        numbers = {f"{float(number):.1f}" for number in re.findall(r"\d+\.\d+", page.read_text())}
        assert figure in numbers, f"{figure} is not in {page.name}"
