"""Mutants of bytes, of YAML and of XML, drawn from a generator.

NumPy's generator draws, not Hypothesis: it makes mutant 7,123 of a seed alone, without those before
it, and does not stop at the first failure to shrink it.
"""

from __future__ import annotations

import copy
import math
import re
import struct
import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar
from xml.etree import ElementTree

import numpy as np
import yaml

Rng = np.random.Generator
T = TypeVar("T")

CHANGES = ("flip", "noise", "cut", "behead", "drop", "insert", "splice", "length", "number",
           "repeat")  # fmt: skip
NUMBERS = (
    "0", "-0", "-1", "1", "1e-320", "1e308", "-1e308", "1e400", ".nan", "nan", ".inf", "-.inf",
    "inf", "1.5", "256", "65536", "2147483648", "9223372036854775808", "9" * 400, "9" * 5000,
    "0." + "0" * 400 + "1", "0x10", "010", "1:30", "1_000", "1e999999999", "+1", "true", "",
)  # fmt: skip
"""Digits, written where a number was."""
WORDS = (
    "",
    " ",
    "\0",
    "\n",
    "..",
    "/",
    "~",
    "\ufeff",
    "é",
    "\u202e",
    "\ud7ff",
    "x" * 100_000,
    "%s",
)
VALUES: tuple[object, ...] = (
    None, True, False, 0, -1, 1, 2, 255, 2**31, 2**63, 2**64, 10**30, 10**400, -0.0, 1e-320, 1e-30,
    0.5, 10.0, 1e3, 1e30, 1e308, -1e308, math.nan, math.inf, -math.inf, "1", *WORDS, [], {}, [[]],
    [None], [1, "x"], [[1, 2], [3]], {"x": 1}, [{}], list(range(10_000)), [[0.0] * 100] * 100,
)  # fmt: skip
"""Put where another value was, of whatever kind."""
SCALES = (0.0, -1.0, 1e-12, 1e-3, 0.5, 2.0, 1e3, 1e12, 1e300)

_LENGTHS = (0, 1, 2**15, 2**16 - 1, 2**24, 2**31 - 1, 2**31, 2**32 - 1)
_DIGITS = re.compile(rb"(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])")
_MARK = "MUTANT_IS_HERE"
# These in C are much faster.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def pick(rng: Rng, of: Sequence[T]) -> T:
    """One of several things."""
    return of[int(rng.integers(len(of)))]


def mutate_bytes(data: bytes, rng: Rng, texts: Sequence[str] = ()) -> bytes:
    """A mutant of some bytes: one change, sometimes more.

    Args:
        data: not empty.
        rng: draws the changes.
        texts: inserted now and then.
    """
    for _ in range(int(rng.geometric(0.7))):
        if texts and rng.random() < 0.15:
            at = int(rng.integers(len(data)))
            data = data[:at] + pick(rng, texts).encode() + data[at:]
        else:
            data = _change_bytes(data, rng) or b" "
    return data


def _change_bytes(data: bytes, rng: Rng) -> bytes:
    """Put a piece where another was."""
    at, other = (int(place) for place in rng.integers(len(data), size=2))
    size = int(rng.integers(1, 2 + len(data) // 4))
    change = pick(rng, CHANGES)
    if change == "number" and (found := list(_DIGITS.finditer(data))):
        digits = pick(rng, found)
        return data[: digits.start()] + pick(rng, NUMBERS).encode() + data[digits.end() :]
    over, piece = None, b""
    match change:
        case "cut":
            over = len(data)
        case "behead":
            at, over = 0, at
        case "drop":
            over = size
        case "insert":
            over, piece = 0, data[other : other + size]
        case "repeat":  # deep nesting, where the piece opens something
            opens = (data[at : at + 8], b"[", b"{", b"- ", b"? ", b"a: ", b"<a>", b"!")
            over, piece = 0, pick(rng, opens) * int(10 ** rng.uniform(1, 5))
        case "splice":
            piece = data[other : other + size]
        case "noise":
            piece = rng.bytes(int(rng.integers(1, 65)))
        case "length":
            piece = struct.pack(pick(rng, ("<I", "<Q")), pick(rng, _LENGTHS))
        case _:
            piece = bytes([data[at] ^ 1 << int(rng.integers(8))])
    return data[:at] + piece + data[at + (len(piece) if over is None else over) :]


def mutate_tree(tree: Any, rng: Rng) -> None:
    """Change a tree of dictionaries and lists in one place, sometimes in more.

    Raises:
        RecursionError: when the tree has become too deep to be copied.
    """
    for _ in range(int(rng.geometric(0.75))):
        if not (places := list(_places(tree))):
            return
        inside, key = pick(rng, places)
        alike = [place for place in places if place[1] == key]
        other, its = pick(rng, pick(rng, (places, alike)))
        _change_tree(inside, key, other[its], its, rng)


def _change_tree(inside: Any, key: Any, other: object, its: object, rng: Rng) -> None:
    """Change the value of a key; `other` is a value elsewhere in the tree, with its key."""
    old, change = inside[key], int(rng.integers(10))
    is_number = isinstance(old, int | float) and not isinstance(old, bool)
    if change == 0:
        del inside[key]
    elif change == 1:
        inside[key] = copy.deepcopy(other)
    elif change == 2 and isinstance(inside, dict):
        inside[pick(rng, (str(its), pick(rng, WORDS)))] = inside.pop(key)
    elif change == 3 and isinstance(old, list):
        inside[key] = old * int(10 ** rng.uniform(0.3, 3.5))
    elif change == 4:
        for _ in range(int(10 ** rng.uniform(0.0, 2.5))):
            inside[key] = [inside[key]]
    elif change in (5, 6) and is_number:
        scale = pick(rng, SCALES)
        # An integer that was scaled before may be one that no float holds.
        inside[key] = old * (scale if abs(old) < sys.float_info.max else int(scale))
    else:
        inside[key] = copy.deepcopy(pick(rng, VALUES))


def _places(tree: object) -> Iterator[tuple[Any, Any]]:
    """Every container in a tree with every key or index of it."""
    parts: Iterable[tuple[Any, object]] = ()
    if isinstance(tree, dict):
        parts = tree.items()
    elif isinstance(tree, list):
        parts = enumerate(tree)
    for key, part in parts:
        yield tree, key
        yield from _places(part)


def hostile(folder: Path) -> tuple[str, ...]:
    """Texts that a careless parser of YAML or XML would run, fetch or unfold."""
    run, trap = f"touch {folder}/canary", f"{folder}/trap"
    return (
        f'!!python/object/apply:os.system ["{run}"]', f"!!python/object/new:os.system ['{run}']",
        f"!!python/object/apply:eval [\"__import__('os').system('{run}')\"]", f"$({run})",
        "!!python/name:os.system", "!!binary aGVsbG8=", "!!set {a, b}", "!!float 'x'",
        "!!timestamp 2026-01-02", "!include trap", "!<tag:yaml.org,2002:int> 5", "&a [*a, *a]",
        "*nowhere", "<<: {x: 1}", "2026-13-45", "2026-01-02 25:61:61", "--- ", "%YAML 9.9\n---",
        "\t", "? {a: 1}\n: 2", trap, "/dev/zero", "file:///etc/passwd", "[" * 3000, "{a: " * 3000,
        "- " * 3000, "&amp;", "&a;", "&#0;", "&#x110000;", "<![CDATA[<robot>]]>", "<!-- ",
        "<?xml?>", "<!DOCTYPE robot>", f'<xi:include href="{trap}"/>',
        f'<?xml-stylesheet href="{trap}"?>',
        f'<visual><geometry><mesh filename="{trap}"/></geometry></visual>', "<robot>", "</robot>",
        '<visual><geometry><mesh filename="package://../../trap"/></geometry></visual>',
        '<collision><geometry><mesh filename="http://127.0.0.1:9/a.stl"/></geometry></collision>',
        "<a>" * 100_000, "<link name='x'/>" * 1000, 'a="1" a="2"', "\ufeff", "<\0>",
    )  # fmt: skip


def mutate_yaml(text: bytes, rng: Rng, folder: Path) -> bytes:
    """A mutant of a YAML file: of its bytes, of its tree, or with a text that a parser may run."""
    texts, kind = hostile(folder), rng.random()
    if kind < 0.35:
        return mutate_bytes(text, rng, texts)
    tree = yaml.load(text, Loader=_LOADER)  # noqa: S506 - a safe one
    raw = ""
    try:
        if kind < 0.5:
            raw = pick(rng, (*NUMBERS, *WORDS, *texts))
            inside, key = pick(rng, list(_places(tree)))
            inside[key] = _MARK
        else:
            mutate_tree(tree, rng)
        written = yaml.dump(
            tree, Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=200
        )
    except RecursionError:
        return mutate_bytes(text, rng, texts)
    return str(written).replace(_MARK, raw).encode()


def mutate_xml(text: bytes, rng: Rng, folder: Path) -> bytes:
    """A mutant of an XML file: of its bytes, of its tree, or with a document type."""
    kind = rng.random()
    if kind < 0.1:
        return _document_type(text, rng, folder)
    if kind < 0.65:
        tree = [_plain(ElementTree.fromstring(text))]  # noqa: S314 - from this checkout
        try:
            mutate_tree(tree, rng)
            if tree:
                return bytes(ElementTree.tostring(_element(tree[0])))
        except RecursionError:
            pass
    return mutate_bytes(text, rng, hostile(folder))


def _plain(element: ElementTree.Element) -> dict[str, Any]:
    """An element as a tree; an attribute is the list of its words."""
    attributes = {name: text.split() for name, text in element.attrib.items()}
    return {"tag": element.tag, "is": attributes, "in": [_plain(child) for child in element]}


def _element(tree: Any) -> ElementTree.Element:
    """The element of a tree, whatever is in it."""
    if not isinstance(tree, dict):
        tree = {"in": tree, "is": {"name": tree}}
    attributes, inside = tree.get("is"), tree.get("in")
    made = ElementTree.Element(str(tree.get("tag", "link")))
    for name, words in attributes.items() if isinstance(attributes, dict) else ():
        made.set(name, " ".join(map(str, words)) if isinstance(words, list) else str(words))
    made.extend(map(_element, inside if isinstance(inside, list) else ()))
    return made


def _document_type(text: bytes, rng: Rng, folder: Path) -> bytes:
    """The file with entities that unfold into gigabytes or name a file, and a use of one."""
    names = "jihgfedcba"
    many = "".join(f'<!ENTITY {name} "{10 * f"&{inner};"}">' for name, inner in pairwise(names))
    trap = f"{folder}/trap"
    declared = pick(
        rng,
        (
            f'[<!ENTITY a "ha">{many}]', f'[<!ENTITY j SYSTEM "{trap}">]',
            f'[<!ENTITY j SYSTEM "file://{trap}">]', f'[<!ENTITY % p SYSTEM "{trap}"> %p;]',
            f'SYSTEM "{trap}"', f'PUBLIC "x" "{trap}"', '[<!ENTITY j "&j;">]',
            '[<!ENTITY j SYSTEM "http://127.0.0.1:9/">]', '[<!ATTLIST mass value CDATA "5">]',
        ),
    )  # fmt: skip
    robot = text[text.index(b"<robot") :]
    used = robot.replace(b"</link>", b"&j;</link>", 1) if rng.random() < 0.8 else robot
    whole = b'<?xml version="1.0"?>' + f"<!DOCTYPE robot {declared}>".encode() + used
    encoding = pick(rng, ("utf-8", "utf-8", "utf-8", "utf-16", "utf-32", "utf-7", "utf-8-sig"))
    return whole.decode().encode(encoding)
