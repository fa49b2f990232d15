"""Files of the configuration, with the comments that explain each key."""

from __future__ import annotations

from pathlib import Path

from reference.markdown import fenced, page, table

_SHOWN = {
    "robots/wren.yaml": "A robot; fields and checks: [your robot](../how-to/your-robot.md).",
    "shoes/nao_shoe.yaml": "A pair of shoes with cells: [your shoe](../how-to/your-shoe.md).",
    "shoes/reemc.yaml": "Feet with six-axis sensors.",
    "nodes/shoe_driver.yaml": "The shoes' device: [protocol](protocol.md).",
    "realities/default.yaml": "A simulated world: [simulation](simulation.md).",
    "manual.yaml": "What a manual calibration is done with: "
    "[manual calibration](../how-to/manual-calibration.md).",
    "imports/reemc.yaml": "What columns of foreign recordings mean: "
    "[recordings](recordings.md#foreign-recordings).",
}
_ELSEWHERE = (
    ("`config/nodes/*.yaml`", "parameters of the nodes", "[parameters](parameters.md)"),
    ("`session/`", "a recording: `session.yaml`, copies of robot and shoe, a run a file",
     "[recordings](recordings.md)"),
    ("`calibration.yaml`", "gains, offsets, covariance, corrections, verdict",
     "[conventions](../guide/conventions.md#order-of-arrays)"),
    ("`--json FILE`", "the figures of a command",
     "[evaluation](../guide/evaluation.md#--json), [screening](screening.md)"),
    ("`config/security/shoecal.policy.xml`", "rights of the nodes under SROS2",
     "[security](security.md)"),
)  # fmt: skip


def files_page(root: Path) -> str:
    """The page.

    Args:
        root: of the checkout.
    """
    parts = [table(("file", "what", "more"), _ELSEWHERE)]
    for name, what in _SHOWN.items():
        parts += [f"## {name}", what, fenced((root / "config" / name).read_text(), "yaml")]
    lead = (
        "The configuration stands in `config/` of the checkout, `share/shoecal_core/config` where "
        "it is installed, or where SHOECAL_CONFIG says. Keys that are not known are refused by "
        "name, newer formats too."
    )
    return page("Files", lead, parts)
