"""Messages, services and actions, as their files define them."""

from __future__ import annotations

from pathlib import Path

from reference.markdown import fenced, page

_KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def interfaces_page(root: Path) -> str:
    """The page.

    Args:
        root: of the checkout.
    """
    parts = []
    for kind, title in _KINDS.items():
        parts.append(f"## {title}")
        for file in sorted((root / "shoecal_msgs" / kind).glob(f"*.{kind}")):
            parts += [f"### {file.stem}", fenced(file.read_text())]
    lead = (
        "As shown by `ros2 interface show shoecal_msgs/KIND/NAME`. Meaning of error codes: "
        "[codes](diagnostics.md#codes)."
    )
    return page("Messages, services and actions", lead, parts)
