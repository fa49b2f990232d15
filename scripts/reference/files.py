"""Files of the configuration and results, each with the page that explains it."""

from __future__ import annotations

from pathlib import Path

from reference.markdown import page, table

_CONFIG = {
    "robots/wren.yaml": ("a robot", "[your robot](../how-to/your-robot.md)"),
    "shoes/nao_shoe.yaml": ("a pair of shoes with cells", "[your shoe](../how-to/your-shoe.md)"),
    "shoes/reemc.yaml": ("feet with six-axis sensors", "[your shoe](../how-to/your-shoe.md)"),
    "nodes/shoe_driver.yaml": ("the shoes' device", "[protocol](protocol.md)"),
    "realities/default.yaml": ("a simulated world", "[simulation](simulation.md)"),
    "manual.yaml": (
        "weights and samples of a manual calibration",
        "[manual calibration](../how-to/manual-calibration.md)",
    ),
    "imports/reemc.yaml": (
        "meaning of columns in foreign recordings",
        "[recordings](recordings.md#foreign-recordings)",
    ),
    "security/shoecal.policy.xml": ("rights of the nodes under SROS2", "[security](security.md)"),
}
_ELSEWHERE = (
    ("`config/nodes/*.yaml`", "parameters of the nodes", "[parameters](parameters.md)"),
    ("`session/`", "a recording: `session.yaml`, copies of robot and shoe file, one file per run",
     "[recordings](recordings.md)"),
    ("`calibration.yaml`", "gains, offsets, covariance, corrections, verdict",
     "[conventions](../guide/conventions.md#order-of-arrays)"),
    ("`randomisation.yaml`", "mean and standard deviation of all that was found of a robot",
     "[train a policy](../how-to/randomise-a-policy.md#the-file)"),
    ("`--json FILE`", "the figures of a command",
     "[evaluation](../guide/evaluation.md#--json), [screening](screening.md)"),
)  # fmt: skip


def files_page(root: Path) -> str:
    """The page.

    Args:
        root: of the checkout.

    Raises:
        FileNotFoundError: when a file that the page names is gone.
    """
    rows = []
    for name, (what, more) in _CONFIG.items():
        (root / "config" / name).stat()
        rows.append((f"[config/{name}](../../config/{name})", what, more))
    lead = (
        "The configuration is in `config/` of the checkout, `share/shoecal_core/config` if "
        "installed, or the folder in SHOECAL_CONFIG. Each file has a comment per key. Unknown "
        "keys and newer formats are rejected with their name."
    )
    return page("Files", lead, [table(("file", "what", "more"), (*rows, *_ELSEWHERE))])
