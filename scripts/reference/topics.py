"""Topics, services and actions of all nodes."""

from __future__ import annotations

from collections.abc import Sequence

from reference.made import Link, Made
from reference.markdown import code, page, table
from shoecal_core.recording.schemas import RUN_TOPICS

_LEAD = "Names are for the empty namespace and relative in the code. Behaviour: [nodes](nodes.md)."

_COMPATIBLE = "A *reliable* subscriber receives nothing from a *best effort* publisher."


def topics_page(made: Sequence[Made]) -> str:
    """The page."""
    links = [link for node in made for link in node.links]
    of = {role: [link for link in links if link.role in role] for role in _ROLES}
    return page(
        "Topics, services and actions",
        _LEAD,
        (
            "## Nodes",
            table(("node", "what it does"), ((code(node.node), node.doc) for node in made)),
            "## Topics",
            _COMPATIBLE,
            _topics(of["publishes, subscribes"]),
            _recorded(),
            "## Services",
            _offered(of["serves, calls"], "serves", ("service", "type", "served by", "called by")),
            "## Actions",
            _offered(
                of["executes, asks"], "executes", ("action", "type", "executed by", "asked by")
            ),
            "Definitions: [interfaces](interfaces.md).",
        ),
    )


_ROLES = ("publishes, subscribes", "serves, calls", "executes, asks")


def _topics(links: Sequence[Link]) -> str:
    rows = []
    for name in sorted({link.name for link in links}):
        here = [link for link in links if link.name == name]
        (kind,) = {link.kind for link in here}
        rows.append(
            (
                code(name),
                kind,
                _ends([link for link in here if link.role == "publishes"]),
                _ends([link for link in here if link.role == "subscribes"]),
            )
        )
    return table(("topic", "type", "published by", "subscribed to by"), rows)


def _ends(links: Sequence[Link]) -> str:
    """Nodes, by the quality of service that they have in common."""
    groups: dict[str, list[str]] = {}
    for link in links:
        nodes = groups.setdefault(link.quality, [])
        if link.node not in nodes:
            nodes.append(link.node)
    return "; ".join(f"{', '.join(nodes)} ({quality})" for quality, nodes in groups.items())


def _offered(links: Sequence[Link], role: str, head: Sequence[str]) -> str:
    rows = []
    for name in sorted({link.name for link in links}):
        here = [link for link in links if link.name == name]
        offers = sorted({link.node for link in here if link.role == role})
        asks = sorted({link.node for link in here if link.role != role})
        rows.append((code(name), here[0].kind, ", ".join(offers), ", ".join(asks)))
    return table(head, rows)


def _recorded() -> str:
    listed = ", ".join(f"{code(name)} ({_short(kind)})" for name, kind in RUN_TOPICS.items())
    return (
        "While it records, the `calibrator` also subscribes to everything that a run holds: "
        f"{listed}. Where tf2_msgs is installed, the `model` publishes `/tf` (reliable, keep last "
        "100)."
    )


def _short(kind: str) -> str:
    return kind.replace("/msg/", "/")
