"""Reading pages and figures as a browser would."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from html.parser import HTMLParser
from xml.etree import ElementTree

VOID = {"meta", "link", "br", "img", "hr", "input"}


@dataclass
class Document(HTMLParser):
    """What a page consists of; unbalanced tags are an error."""

    text: str = ""
    tags: Counter[str] = field(default_factory=Counter)
    ids: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    attributes: set[str] = field(default_factory=set)
    _open: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        if tag not in VOID:
            self._open.append(tag)
        for name, value in attrs:
            self.attributes.add(name)
            if name == "id":
                self.ids.append(value or "")
            if name in {"href", "src", "xlink:href", "action", "data"}:
                self.links.append(value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open, f"</{tag}> closes nothing"
        assert self._open.pop() == tag
        self.text += " "

    def handle_data(self, data: str) -> None:
        if "style" not in self._open:
            self.text += data


def read(html: str) -> Document:
    document = Document()
    document.feed(html)
    document.close()
    assert not document._open
    document.text = " ".join(document.text.split())
    return document


def read_svg(svg: str) -> ElementTree.Element:
    """A figure, checked: it stands alone, is bounded, and tells what it shows."""
    root = ElementTree.fromstring(svg)
    assert root.tag == "svg"
    assert root.get("role") == "img"
    assert root.get("aria-label")
    assert len(svg) < 300_000
    found = {element.get("id") for element in root.iter() if element.get("id")}
    used = {
        element.get("href", "").removeprefix("#") for element in root.iter() if element.get("href")
    }
    assert used <= found
    assert "http" not in svg
    return root
