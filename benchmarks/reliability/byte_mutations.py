"""What happens to bytes: flipped bits, cuts, splices, and numbers at their extremes."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

Rng = np.random.Generator

NUMBERS = (
    "0", "-0", "-1", "1", "1e-320", "1e308", "-1e308", "1e400", "-1e400", ".nan", "nan", ".inf",
    "-.inf", "inf", "1e5", "1.5", "255", "256", "65536", "2147483648", "4294967296",
    "9223372036854775808", "18446744073709551616", "9" * 400, "9" * 5000, "0." + "0" * 400 + "1",
    "0x10", "010", "1:30", "1_000", "1e999999999", "+1", "true", "", "[]", "{}",
)  # fmt: skip
"""Written where a number stood."""
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
_NUMBER = re.compile(rb"(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])")
_LENGTHS = (
    0, 1, 2**15, 2**16 - 1, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**63 - 1, 2**64 - 1,
)  # fmt: skip


def mutate_bytes(data: bytes, rng: Rng, texts: Sequence[str] = ()) -> tuple[str, bytes]:
    """A mutant of some bytes: one change, seldom a few.

    Args:
        data: not empty.
        rng: draws the change.
        texts: to be spliced in now and then.

    Returns:
        What was done, and the mutant.
    """
    done = []
    for _ in range(int(rng.geometric(0.7))):
        name, change = _CHANGES[int(rng.integers(len(_CHANGES)))]
        if texts and rng.random() < 0.15:
            name, change = "text put in", partial(_put, texts=texts)
        data = change(data, rng) or b" "
        done.append(name)
    return ", ".join(done), data


def pick(rng: Rng, of: Sequence[str]) -> str:
    """One of some texts."""
    return of[int(rng.integers(len(of)))]


def _place(data: bytes, rng: Rng) -> int:
    return int(rng.integers(len(data)))


def _flip(data: bytes, rng: Rng) -> bytes:
    altered = bytearray(data)
    for place in rng.integers(len(data), size=int(rng.geometric(0.5))):
        altered[place] ^= 1 << int(rng.integers(8))
    return bytes(altered)


def _overwrite(data: bytes, rng: Rng) -> bytes:
    at = _place(data, rng)
    fresh = rng.bytes(int(rng.integers(1, 65)))
    return data[:at] + fresh + data[at + len(fresh) :]


def _cut(data: bytes, rng: Rng) -> bytes:
    return data[: _place(data, rng)]


def _behead(data: bytes, rng: Rng) -> bytes:
    return data[_place(data, rng) :]


def _splice(data: bytes, rng: Rng) -> bytes:
    """A piece from one place in another, in place of what was there or before it."""
    at, begin = _place(data, rng), _place(data, rng)
    piece = data[begin : begin + int(rng.integers(1, 2 + len(data) // 4))]
    over = len(piece) if rng.random() < 0.5 else 0
    return data[:at] + piece + data[at + over :]


def _drop(data: bytes, rng: Rng) -> bytes:
    at = _place(data, rng)
    return data[:at] + data[at + int(rng.integers(1, 2 + len(data) // 4)) :]


def _length(data: bytes, rng: Rng) -> bytes:
    """A count or a length that cannot be."""
    at, wide = _place(data, rng), rng.random() < 0.5
    value = _LENGTHS[int(rng.integers(len(_LENGTHS)))]
    fresh = struct.pack("<Q", value) if wide else struct.pack("<I", value % 2**32)
    return data[:at] + fresh + data[at + len(fresh) :]


def _number(data: bytes, rng: Rng) -> bytes:
    """A number in digits at an extreme."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return _flip(data, rng)
    one = found[int(rng.integers(len(found)))]
    return data[: one.start()] + pick(rng, NUMBERS).encode() + data[one.end() :]


def _repeat(data: bytes, rng: Rng) -> bytes:
    """One piece very often: deep nesting, where it opens something."""
    at = _place(data, rng)
    piece = data[at : at + int(rng.integers(1, 9))]
    if rng.random() < 0.3:
        piece = pick(rng, ("[", "{", "- ", "? ", "a: ", "<a>", '"', "&a ", "*a ", "!")).encode()
    times = int(10 ** rng.uniform(1, 5))
    return data[:at] + piece * times + data[at:]


def _put(data: bytes, rng: Rng, texts: Sequence[str]) -> bytes:
    at = _place(data, rng)
    return data[:at] + pick(rng, texts).encode(errors="surrogatepass") + data[at:]


_CHANGES: tuple[tuple[str, Callable[[bytes, Rng], bytes]], ...] = (
    ("bits flipped", _flip),
    ("bytes overwritten", _overwrite),
    ("cut", _cut),
    ("beheaded", _behead),
    ("spliced", _splice),
    ("piece dropped", _drop),
    ("length at an extreme", _length),
    ("number at an extreme", _number),
    ("piece repeated", _repeat),
)
