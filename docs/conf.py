"""The documentation as a site: plain Markdown, built by Sphinx (`make docs`)."""

from __future__ import annotations

import re
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

HERE = Path(__file__).resolve().parent

project = "shoecal"
author = "The shoecal authors"
_PACKAGE = (HERE.parent / "shoecal_core" / "package.xml").read_text(encoding="utf-8")
release = "".join(re.findall(r"<version>(.*)</version>", _PACKAGE))
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "tasklist"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
html_theme = "furo"
html_math_renderer = "mathml"
html_title = f"shoecal {release}"
html_show_copyright = False

# Not to be checked as code of the language that a fence names: excerpts, and lines of a shell.
suppress_warnings = ["misc.highlighting_failure"]

_LINK = re.compile(r"\]\(([^)#:]+\.md)\)|\]\(([^)#:]+\.md)#[^)]*\)")


def _contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Give the front page a table of contents, out of its own sections and links.

    So the Markdown stays plain, and reads as well where no site is built of it.
    """
    del app
    if page != "index":
        return
    trees = []
    for section in source[0].split("\n## ")[1:]:
        title, _, body = section.partition("\n")
        pages = dict.fromkeys(name.removesuffix(".md") for name in _linked(body))
        entries = "\n".join(name for name in pages if name not in _generated())
        trees.append(f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n{entries}\n```")
    source[0] += "\n" + "\n\n".join(trees) + "\n"


def _reference(app: Sphinx, page: str, source: list[str]) -> None:
    del app
    if page == "reference/index":
        names = "\n".join(name.removesuffix(".md") for name in _linked(source[0]))
        source[0] += f"\n```{{toctree}}\n:hidden:\n\n{names}\n```\n"


def _linked(text: str) -> list[str]:
    return [plain or anchored for plain, anchored in _LINK.findall(text)]


def _generated() -> set[str]:
    """Pages that the table of contents of the generated reference lists."""
    index = (HERE / "reference" / "index.md").read_text(encoding="utf-8")
    return {f"reference/{name.removesuffix('.md')}" for name in _linked(index)}


def _inline_math(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _display_math(writer: HTML5Translator, node: nodes.math_block) -> None:
    writer.body.append(convert(node.astext(), display="block"))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    # MathML, which browsers draw by themselves: the site needs no network and no script.
    app.add_html_math_renderer("mathml", (_inline_math, None), (_display_math, None))
    app.connect("source-read", _contents)
    app.connect("source-read", _reference)
