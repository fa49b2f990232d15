"""Mutants of YAML that keep its form: other values, other kinds, more or less of them."""

from __future__ import annotations

import copy
import math
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from reliability.byte_mutations import NUMBERS, WORDS, mutate_bytes, pick

Rng = np.random.Generator
Place = tuple[Any, Any]
"""A container and the key or index of something in it."""

_VALUES: tuple[object, ...] = (
    None, True, False, 0, -1, 1, 2, 7, 255, 256, 2**31, 2**63, 2**64, 10**30, 10**400, 0.0, -0.0,
    1e-320, 1e-30, 1e-3, 0.5, 1.0, 10.0, 1e3, 1e30, 1e308, -1e308, math.nan, math.inf, -math.inf,
    "", "x", "1", "true", "x" * 100_000, "a\nb", "\u202eab", [], {}, [[]], [None], [1, "x"],
    [[1, 2], [3]], {"x": 1}, [{}], [{"x": 1}], list(range(10_000)), [[0.0] * 100] * 100,
)  # fmt: skip
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the one in C is much faster
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_SCALES = (0.0, -1.0, 1e-12, 1e-3, 0.5, 2.0, 1e3, 1e12, 1e300)
_MARK = "MUTANT_STANDS_HERE"


def hostile(folder: Path) -> tuple[str, ...]:
    """Texts that would run, fetch or unfold something with a careless reader."""
    run = f"touch {folder}/canary"
    return (
        f'!!python/object/apply:os.system ["{run}"]',
        f"!!python/object/new:os.system ['{run}']",
        f'!!python/object/apply:subprocess.Popen [["touch", "{folder}/canary"]]',
        f"!!python/object/apply:eval [\"__import__('os').system('{run}')\"]",
        "!!python/name:os.system", "!!python/module:os", "!!binary aGVsbG8=", "!!set {a, b}",
        "!!float 'x'", "!!timestamp 2026-01-02", "!include trap", "!<tag:yaml.org,2002:int> 5",
        "&a [*a, *a]", "*nowhere", "<<: {x: 1}", "2026-13-45", "2026-01-02 25:61:61", "--- ",
        "%YAML 9.9\n---", "\t", "? {a: 1}\n: 2", "? [1, 2]\n: 2",
        f"`{run}`", f"$({run})", f"${{{run}}}", f"{folder}/trap", "/dev/zero", "file:///etc/passwd",
        "[" * 3000, "{a: " * 3000, "- " * 3000, "? " * 3000, "!" * 3000, "&" * 3000,
    )  # fmt: skip


def mutate_yaml(text: bytes, rng: Rng, folder: Path) -> tuple[str, bytes]:
    """A mutant of a YAML file: of its bytes, or of what it says."""
    if rng.random() < 0.35:
        return mutate_bytes(text, rng, hostile(folder))
    tree = yaml.load(text, Loader=_LOADER)  # noqa: S506 - a safe one
    done, raw = [], ""
    for _ in range(int(rng.geometric(0.75))):
        places = list(_places(tree))
        if not places:
            break
        what, raw = _change(places, rng, folder)
        done.append(what)
    try:
        written = yaml.dump(
            tree, Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=200
        )
    except RecursionError:  # nested deeper and deeper; texts of that kind are among the hostile
        return mutate_bytes(text, rng, hostile(folder))
    if raw:
        written = written.replace(_MARK, raw)
    return ", ".join(done), written.encode(errors="surrogatepass")


def _places(tree: object) -> Iterator[Place]:
    parts: Iterable[tuple[Any, object]] = ()
    if isinstance(tree, dict):
        parts = tree.items()
    elif isinstance(tree, list):
        parts = enumerate(tree)
    for key, part in parts:
        yield tree, key
        yield from _places(part)


def _change(places: list[Place], rng: Rng, folder: Path) -> tuple[str, str]:
    """Change one place; what was done, and what is to be written there as it is."""
    inside, key = places[int(rng.integers(len(places)))]
    old, kind = inside[key], rng.random()
    where = f"'{str(key)[:40]}'"
    if kind < 0.2 and isinstance(old, int | float) and not isinstance(old, bool):
        scale = _SCALES[int(rng.integers(len(_SCALES)))]
        # What was scaled before may be an integer that no float holds.
        inside[key] = old * (scale if abs(old) < sys.float_info.max else int(scale))
        return f"{where} scaled", ""
    if kind < 0.45:
        value = _VALUES[int(rng.integers(len(_VALUES)))]
        inside[key] = value
        return f"{where} made {str(value)[:20]!r}", ""
    if kind < 0.6:
        raw = pick(rng, (*NUMBERS, *WORDS, *hostile(folder)))
        inside[key] = _MARK
        return f"{where} made {raw[:40]!r}", raw
    return _rearrange(places, inside, key, rng), ""


def _rearrange(places: list[Place], inside: Any, key: Any, rng: Rng) -> str:
    old, where = inside[key], f"'{str(key)[:40]}'"
    other, its = places[int(rng.integers(len(places)))]
    kind = int(rng.integers(6))
    if kind == 0:
        del inside[key]
        return f"{where} deleted"
    if kind == 1:
        inside[key] = copy.deepcopy(other[its])
        return f"{where} made what '{str(its)[:40]}' is"
    if kind == 2 and isinstance(inside, dict):
        word = pick(rng, WORDS) if rng.random() < 0.5 else str(its)
        inside[word] = inside.pop(key)
        return f"{where} renamed"
    if kind == 3 and isinstance(old, list):
        inside[key] = old * int(10 ** rng.uniform(0.3, 3.5))
        return f"{where} repeated"
    if kind == 4:
        depth = int(10 ** rng.uniform(0.5, 2.5))
        for _ in range(depth):
            old = [old]
        inside[key] = old
        return f"{where} {depth} lists deep"
    inside[key] = [old]
    return f"{where} in a list"
