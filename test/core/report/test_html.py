from __future__ import annotations

import re
from pathlib import Path

import pytest

from core.report.pages import read
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.report.html import render, write_page
from shoecal_core.report.page import (
    Group,
    KeyFigure,
    Page,
    PageVerdict,
    Picture,
    Reason,
    Section,
    Table,
)

HOSTILE = "<script>alert(1)</script>\"'>&amp;<img src=x onerror=alert(1)> ' onload='x"


def page(text: str = "text", level: str = "WARN") -> Page:
    return Page(
        title=text,
        subtitle=text,
        verdict=PageVerdict(level, text, (Reason("FAIL", text), Reason("WARN", text))),
        key_figures=(KeyFigure(text, "2.72\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}1.09 mm", text),),
        sections=(
            Section(
                text,
                (
                    Group(
                        text,
                        text,
                        (Picture(text, "<svg viewBox='0 0 1 1'></svg>", text, tall=True),),
                        (Table(text, ("", text), ((text, text), (text, "–")), text),),
                    ),
                    Group(),
                ),
                text,
            ),
        ),
        provenance=(text,),
    )


def test_every_text_is_escaped() -> None:
    document = read(render(page(HOSTILE)))
    assert document.tags == read(render(page())).tags
    assert "script" not in document.tags
    assert not {name for name in document.attributes if name.startswith("on")}
    # Once in every place, and in two for the text that is told twice.
    assert document.text.count(" ".join(HOSTILE.split())) >= 20


def test_nothing_is_loaded_and_nothing_runs() -> None:
    html = render(page())
    document = read(html)
    assert all(link.startswith("#") for link in document.links)
    assert not re.search(r"@import|url\(\s*['\"]?(?!#)|https?:", html)
    assert not {"script", "link", "iframe", "object", "embed"} & set(document.tags)
    assert "default-src 'none'" in html


def test_links_within_the_page_lead_somewhere() -> None:
    document = read(render(page()))
    inner = {link.removeprefix("#") for link in document.links}
    assert inner <= set(document.ids)
    assert len(document.ids) == len(set(document.ids))


@pytest.mark.parametrize("level", ["PASS", "WARN", "FAIL"])
def test_the_verdict_comes_first(level: str) -> None:
    text = read(render(page("something", level))).text
    body = text[text.index("shoecal") :]
    assert body.index(level) < body.index("2.72")
    assert re.search(rf"[✓!✕] {level}", body)


def test_light_dark_phone_and_print() -> None:
    html = render(page())
    assert "prefers-color-scheme:dark" in html
    assert "@media print" in html
    assert "max-width:640px" in html
    assert 'name="viewport"' in html
    declared = set(re.findall(r"--([a-z]+):", html))
    assert set(re.findall(r"var\(--([a-z]+)\)", html)) <= declared


def test_the_same_page_is_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.html", "other.html"):
        write_page(tmp_path / name, page())
    one, other = ((tmp_path / name).read_bytes() for name in ("one.html", "other.html"))
    assert one == other
    assert [file.name for file in sorted(tmp_path.iterdir())] == ["one.html", "other.html"]


def test_text_that_no_encoding_knows(tmp_path: Path) -> None:
    write_page(tmp_path / "page.html", page("a\ud800b"))
    read((tmp_path / "page.html").read_text(encoding="utf-8"))


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        write_page(tmp_path / "none" / "page.html", page())


def test_content_that_does_not_fit() -> None:
    with pytest.raises(ShoecalError, match="row has 1 cells, its header 2"):
        Table("t", ("", "a"), (("x",),))
    with pytest.raises(ShoecalError, match="'GOOD' is no verdict"):
        Reason("GOOD", "x")
    with pytest.raises(ShoecalError, match="'good' is no verdict"):
        PageVerdict("good", "x", ())
