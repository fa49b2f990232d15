"""Robot descriptions (URDF) that were tampered with.

Besides altered bytes: numbers at their extremes, elements gone, repeated, put elsewhere, or nested
very deep; links that hang on each other in a circle; names that are no names; document types with
entities that unfold into gigabytes or name a file; meshes anywhere. A mutant is refused with one
line that names the file, or makes a model of finite numbers whose masses are the file's; within
2 GiB and 10 s of the processor's time. No other file is opened: a pipe that nobody writes to lies
in wait under the names that the mutants mention.
"""

from __future__ import annotations

import copy
import shutil
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from reliability import originals
from reliability.byte_mutations import NUMBERS, WORDS, mutate_bytes, pick
from reliability.loading import WrongLoadError, make_trap, try_mutants
from reliability.row import Row
from shoecal_core.errors import FieldError
from shoecal_core.model.robot_file import load_robot
from shoecal_core.model.urdf import UrdfError, read_urdf

Rng = np.random.Generator
FILES = ("nao.urdf", "wren.urdf")


def target(folder: Path) -> UrdfFiles:
    """The robots of config/."""
    return UrdfFiles(folder)


class UrdfFiles:
    """Robots whose URDF is a mutant, one at a time."""

    codes = frozenset({"file-syntax", "urdf"})

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        shutil.copytree(originals.CONFIG / "robots", folder, dirs_exist_ok=True)
        make_trap(folder)
        self._whole = {name: (folder / name).read_bytes() for name in FILES}
        self._name = FILES[0]

    def mutate(self, rng: Rng) -> str:
        (self._folder / self._name).write_bytes(self._whole[self._name])
        self._name = FILES[int(rng.integers(len(FILES)))]
        whole = self._whole[self._name]
        if rng.random() < 0.35:
            what, mutant = mutate_bytes(whole, rng, hostile(self._folder))
        elif rng.random() < 0.15:
            what, mutant = "document type", document_type(whole, rng, self._folder)
        else:
            what, mutant = mutate_xml(whole, rng, self._folder)
        (self._folder / self._name).write_bytes(mutant)
        return f"{self._name}: {what}"

    def load(self) -> None:
        path = self._folder / self._name
        model = read_urdf(path).model
        for inertia, place in zip(model.inertias, model.jointPlacements, strict=True):
            if not (np.isfinite(inertia.matrix()).all() and np.isfinite(place.homogeneous).all()):
                raise WrongLoadError("a place or an inertia that is not finite")
        try:
            robot = load_robot(path.with_suffix(".yaml"))
        except (FieldError, UrdfError):
            return  # the robot file names links and joints that are others now
        if abs(sum(inertia.mass for inertia in robot.model.inertias) - robot.mass) > 1e-6:
            raise WrongLoadError("the model's masses are not the robot's")


def hostile(folder: Path) -> tuple[str, ...]:
    """Texts that mean something else to one reader of XML or another."""
    trap = folder / "trap"
    return (
        "&amp;", "&a;", "&#0;", "&#x110000;", "<![CDATA[<robot>]]>", "<!-- ", "-->", "<?xml?>",
        "<!DOCTYPE robot>", f'<xi:include href="{trap}"/>', f'<?xml-stylesheet href="{trap}"?>',
        f'<visual><geometry><mesh filename="{trap}"/></geometry></visual>', "<robot>", "</robot>",
        '<visual><geometry><mesh filename="package://../../trap"/></geometry></visual>',
        '<collision><geometry><mesh filename="http://127.0.0.1:9/a.stl"/></geometry></collision>',
        "<a>" * 100_000, "<link name='x'/>" * 1000, 'a="1" a="2"', "\ufeff", "<\0>",
        f"$(touch {folder}/canary)", f"${{__import__('os').system('touch {folder}/canary')}}",
    )  # fmt: skip


def document_type(whole: bytes, rng: Rng, folder: Path) -> bytes:
    """The file with entities, and a use of one of them."""
    many = "".join(
        f'<!ENTITY {new} "{f"&{old};" * 10}">'
        for old, new in zip("abcdefghi", "bcdefghij", strict=True)
    )
    kinds = (
        f'<!DOCTYPE robot [<!ENTITY a "ha">{many}]>',
        f'<!DOCTYPE robot [<!ENTITY j SYSTEM "{folder}/trap">]>',
        f'<!DOCTYPE robot [<!ENTITY j SYSTEM "file://{folder}/trap">]>',
        f'<!DOCTYPE robot [<!ENTITY % p SYSTEM "{folder}/trap"> %p;]>',
        f'<!DOCTYPE robot SYSTEM "{folder}/trap">',
        f'<!DOCTYPE robot PUBLIC "x" "{folder}/trap">',
        '<!DOCTYPE robot [<!ENTITY j SYSTEM "http://127.0.0.1:9/">]>',
        '<!DOCTYPE robot [<!ATTLIST mass value CDATA "5">]>',
        '<!DOCTYPE robot [<!ENTITY j "&j;">]>',
    )
    declared = pick(rng, kinds).encode()
    at = whole.index(b"<robot")
    used = whole[at:].replace(b"</link>", b"&j;</link>", 1) if rng.random() < 0.8 else whole[at:]
    encoding = (b"", b'<?xml version="1.0"?>', b'<?xml version="1.0" encoding="UTF-8"?>')
    text = encoding[int(rng.integers(len(encoding)))] + declared + used
    if rng.random() < 0.15:
        return text.decode().encode(("utf-16", "utf-32", "utf-7", "utf-8-sig")[rng.integers(4)])
    return text


def mutate_xml(whole: bytes, rng: Rng, folder: Path) -> tuple[str, bytes]:
    """A mutant that is still XML."""
    root = ElementTree.fromstring(whole)  # noqa: S314 - from this checkout
    done: list[str] = []
    mutant = ElementTree.tostring(root)
    for _ in range(int(rng.geometric(0.7))):
        parents = [one for one in root.iter() if len(one)]
        owners = [one for one in root.iter() if one.attrib]
        if not (parents and owners):
            break
        owner = owners[int(rng.integers(len(owners)))]
        parent = parents[int(rng.integers(len(parents)))]
        try:
            if rng.random() < 0.6:
                what = _attribute(owner, owners, rng, folder)
            else:
                what = _element(parent, parents, rng)
            mutant = ElementTree.tostring(root)
        except RecursionError:  # nested deeper than its maker can copy or write
            break
        done.append(what)
    return ", ".join(done), mutant


def _attribute(
    owner: ElementTree.Element, owners: list[ElementTree.Element], rng: Rng, folder: Path
) -> str:
    """Another value of one attribute, or another attribute."""
    name = pick(rng, list(owner.attrib))
    others = [other.get(name, "") for other in owners if other.get(name) and other is not owner]
    kind, told = int(rng.integers(7)), f"{name} of <{owner.tag}>"
    if kind == 0:
        del owner.attrib[name]
        return f"{told} deleted"
    if kind in (1, 2):
        words = owner.attrib[name].split() or [""]
        words[int(rng.integers(len(words)))] = pick(rng, NUMBERS)
        owner.attrib[name] = " ".join(words)
    elif kind == 3 and others:
        owner.attrib[name] = pick(rng, others)
    elif kind == 4:
        owner.attrib["x"] = owner.attrib.pop(name)
        return f"{told} renamed"
    elif kind == 5:
        owner.attrib[name] = pick(
            rng,
            (
                str(folder / "trap"),
                "fixed",
                "floating",
                "planar",
                "continuous",
                "prismatic",
                "revolute",
                "world",
                "unknown",
            ),
        )
    else:
        owner.attrib[name] = pick(rng, [word for word in WORDS if word not in "\0\ud7ff"])
    return f"{told} made {owner.attrib[name][:30]!r}"


def _element(parent: ElementTree.Element, parents: list[ElementTree.Element], rng: Rng) -> str:
    """An element gone, repeated, put elsewhere or nested deep."""
    at = int(rng.integers(len(parent)))
    child, kind = parent[at], int(rng.integers(5))
    if kind == 0:
        del parent[at]
        return f"<{child.tag}> deleted"
    if kind == 1:
        times = int(10 ** rng.uniform(0.0, 3.5)) if len(list(child.iter())) < 20 else 1
        for _ in range(times):
            parent.append(copy.deepcopy(child))
        return f"<{child.tag}> repeated {times} times"
    if kind == 2:
        other = parents[int(rng.integers(len(parents)))]
        other.append(copy.deepcopy(child))
        return f"<{child.tag}> put into <{other.tag}>"
    if kind == 3:
        depth = int(10 ** rng.uniform(0.5, 2.8))
        for _ in range(depth):
            inner, child = child, ElementTree.Element(child.tag, dict(child.attrib))
            child.append(inner)
        parent[at] = child
        return f"<{child.tag}> nested {depth} deep"
    child.tag = pick(rng, ("link", "joint", "inertial", "mass", "mimic", "limit", "robot", "x"))
    return f"an element renamed <{child.tag}>"


ROW = Row(
    key="mutants-urdf",
    fault="mutated URDF, entities and meshes that name other files among them",
    holds="refused with one line that names the file, or a model of finite numbers; at most 2 GiB "
    "and 10 s of the processor; nothing is fetched",
    tries=10_000,
    step=500,
    run=partial(try_mutants, "mutated_urdfs"),
)
