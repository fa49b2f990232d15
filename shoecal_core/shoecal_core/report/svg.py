"""From a Matplotlib figure to SVG that lives inside a page.

Every figure is 380 units wide, one column of a page: on a phone it is shown at about that many
pixels, so its text can be read there, and on a wide screen several stand side by side.
"""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from xml.etree import ElementTree

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from shoecal_core.arrays import FloatArray
from shoecal_core.report.palette import COLOURS, INK, MUTED, RULE, Colour, Look

WIDTH = 380.0
"""Units of a figure's width; Matplotlib's points."""
TEXT = 10.0
SMALL = 9.0
MARKERS = "os^DvPX"
"""One after the other, in addition to colours."""
LINE = 17.0
"""Units from one row of a legend to the next."""

_NAMESPACE = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")
_FONT_FAMILY = re.compile(r"font-family:[^;]*;?\s*")
_FONT = re.compile(r"font:\s*(?:\d+\s+)?([\d.]+px)[^;]*")
_CLIP_PATH = re.compile(r'<clipPath id="([^"]*)"')
_REFERENCE = re.compile(r"url\(#([^)]*)\)")


class Canvas:
    """One figure, its parts placed in units from its upper left corner."""

    def __init__(self, height: float) -> None:
        self.height = height
        self.figure = Figure(figsize=(WIDTH / 72.0, height / 72.0))

    def panel(
        self, top: float, height: float, left: float = 50.0, right: float = WIDTH - 8.0
    ) -> Axes:
        """Axes whose frame fills a rectangle."""
        axes = self.figure.add_axes(
            (left / WIDTH, 1.0 - (top + height) / self.height, (right - left) / WIDTH,
             height / self.height)
        )  # fmt: skip
        axes.set_axisbelow(True)
        return axes

    def legends(self, handles: Sequence[Artist], per_line: int, left: float = 0.0) -> None:
        """Rows of legend entries, LINE high each."""
        for row, begin in enumerate(range(0, len(handles), per_line)):
            self.legend(handles[begin : begin + per_line], left, LINE * row)

    def legend(self, handles: Sequence[Artist], left: float = 0.0, top: float = 0.0) -> None:
        """One row of legend entries, labelled by the handles themselves."""
        self.figure.legend(
            handles=list(handles),
            loc="upper left",
            bbox_to_anchor=(left / WIDTH, 1.0 - top / self.height),
            ncol=len(handles),
            borderaxespad=0.2,
            handlelength=1.7,
            handletextpad=0.4,
            columnspacing=1.1,
        )

    def write(self, x: float, y: float, text: str, **style: object) -> None:
        """Text at a place in units."""
        # Matplotlib's own signature takes the properties of a text one by one.
        self.figure.text(x / WIDTH, 1.0 - y / self.height, text, **style)  # type: ignore[arg-type]

    def svg(self, alt: str) -> str:
        """The figure as an `<svg>` element.

        Args:
            alt: what is to be seen, for those who do not see it.
        """
        buffer = io.BytesIO()
        self.figure.savefig(
            buffer, format="svg", transparent=True, metadata={"Date": None, "Creator": None}
        )
        return _inline(buffer.getvalue().decode(), alt)


@contextmanager
def canvas(height: float) -> Iterator[Canvas]:
    """A figure to draw on, in the reports' style; the style ends with the block."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(
            {
                "axes.edgecolor": RULE.light,
                "axes.grid": True,
                "axes.labelcolor": INK.light,
                "axes.labelsize": TEXT,
                "axes.linewidth": 0.8,
                "axes.spines.right": False,
                "axes.spines.top": False,
                "axes.titlecolor": INK.light,
                "axes.titlesize": TEXT,
                "font.size": TEXT,
                "grid.color": RULE.light,
                "grid.linewidth": 0.6,
                "hatch.color": INK.light,
                "path.simplify_threshold": 0.8,
                "legend.fontsize": SMALL,
                "legend.frameon": False,
                "legend.labelcolor": INK.light,
                "svg.fonttype": "none",
                "svg.hashsalt": "shoecal",
                "text.color": INK.light,
                "text.parse_math": False,
                "xtick.color": RULE.light,
                "xtick.labelcolor": MUTED.light,
                "xtick.labelsize": SMALL,
                "ytick.color": RULE.light,
                "ytick.labelcolor": MUTED.light,
                "ytick.labelsize": SMALL,
            }
        )
        yield Canvas(height)


def draw_line(axes: Axes, x: FloatArray, y: FloatArray, look: Look) -> None:
    """A line through points x (T,), y (T,); NaN leaves a gap."""
    (line,) = axes.plot(x, y, color=look.colour.light, linewidth=look.width)
    line.set_solid_capstyle("round")
    if look.dashes:
        line.set_dashes(look.dashes)


def line_key(look: Look, label: str) -> Line2D:
    """Legend entry of a line."""
    line = Line2D([], [], color=look.colour.light, linewidth=look.width, label=readable(label))
    if look.dashes:
        line.set_dashes(look.dashes)
    return line


def area_key(colour: Colour, label: str) -> Patch:
    """Legend entry of what is filled."""
    return Patch(facecolor=colour.light, edgecolor="none", label=readable(label))


def marker_key(
    marker: str, colour: Colour, label: str, size: float = 4.5, *, filled: bool = False
) -> Line2D:
    """Legend entry of a marker that stands alone."""
    return Line2D(
        [], [], linestyle="", marker=marker, markersize=size, color=colour.light, label=label,
        markerfacecolor=colour.light if filled else "none",
    )  # fmt: skip


def y_label(axes: Axes, text: str) -> None:
    """Name of the vertical axis, as far from the frame as in every other figure."""
    axes.set_ylabel(text)
    axes.yaxis.set_label_coords(-38.0 / (WIDTH * axes.get_position().width), 0.5)


def readable(text: str, most: int = 28) -> str:
    """Text that can stand in a figure: printable, in one line, not too long."""
    clean = "".join(letter if letter.isprintable() else "�" for letter in text)
    return clean if len(clean) <= most else clean[: most - 1] + "…"


def _inline(document: str, alt: str) -> str:
    # Matplotlib before 3.8 names some of them by their place in memory.
    for number, name in enumerate(_CLIP_PATH.findall(document)):
        document = document.replace(name, f"clip{number}")
    prefix = f"f{hashlib.sha256(document.encode()).hexdigest()[:8]}"
    root = ElementTree.fromstring(document)  # noqa: S314 - written by Matplotlib a moment ago
    for child in list(root):
        if child.tag == f"{_NAMESPACE}metadata" or child.find(f"{_NAMESPACE}style") is not None:
            root.remove(child)
    for element in root.iter():
        element.tag = element.tag.removeprefix(_NAMESPACE)
        _tidy(element, prefix)
    box = root.get("viewBox", "")
    root.attrib.clear()
    root.attrib.update({"viewBox": box, "role": "img", "aria-label": alt})
    return ElementTree.tostring(root, encoding="unicode")


def _tidy(element: ElementTree.Element, prefix: str) -> None:
    """Short numbers, colours as variables, the page's font, identifiers of this figure alone."""
    for text in ("text", "tail"):
        if not (getattr(element, text) or "").strip():
            setattr(element, text, None)
    identifier = element.attrib.pop("id", None)
    if identifier is not None and element.tag != "g":
        element.set("id", f"{prefix}{identifier}")
    link = element.attrib.pop(_LINK, None)
    if link is not None:
        element.set("href", f"#{prefix}{link.removeprefix('#')}")
    for name, value in element.attrib.items():
        if name not in {"id", "href"}:
            short = _LONG_NUMBER.sub(lambda match: f"{float(match[0]):.2f}", value)
            local = _REFERENCE.sub(rf"url(#{prefix}\1)", " ".join(short.split()))
            element.set(name, _themed(local) if name == "style" else local)


def _themed(style: str) -> str:
    style = _FONT.sub(r"font-size: \1", _FONT_FAMILY.sub("", style))
    for colour in COLOURS:
        style = style.replace(colour.light, f"var(--{colour.name})")
    return style
