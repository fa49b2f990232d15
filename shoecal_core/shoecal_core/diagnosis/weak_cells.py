"""Cells that hardly answer, from the start on.

A gain makes up for that, so that no signal shows it: but cells of one shoe are of one kind.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shoecal_core.diagnosis.result import Cause, Size
from shoecal_core.diagnosis.shrink import shrink
from shoecal_core.diagnosis.sizes import Z95
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.base import Place
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.signals import COP

TOO_LARGE = 2.5
"""Gain of a cell, over the usual one of its shoe's, from which it does not answer as others do."""
SURE = 5.0
"""Standard deviations by which a gain must differ from zero to be believed."""
SPREAD = 0.2
"""How far gains of cells of one kind are apart, over themselves."""
FEWEST = 3
"""Cells from which on there is a usual gain."""


def weak_cells(workspace: Workspace, wanted: Callable[[str, Place], bool]) -> list[Cause]:
    """A stuck cell for each that shows but a small part of what it feels: the rest stays.

    Args:
        wanted: whether to look for an effect at a place.
    """
    signal_model = workspace.signal_model
    shoe = signal_model.samples.shoe
    cells = places.cells(shoe)
    if len(cells) < FEWEST or any(shoe.channels[cell].nominal_gain is not None for cell in cells):
        return []
    gain = np.abs(signal_model.parameters.gain[cells])
    spread = np.sqrt(np.diag(workspace.scorer.nothing.covariance))[cells]
    usual = float(np.median(gain))
    found = []
    for cell in cells[(gain > TOO_LARGE * usual) & (gain > SURE * spread)].tolist():
        place = (shoe.names[cell],)
        if not wanted("stuck_cell", place):
            continue
        shown = usual / abs(float(signal_model.parameters.gain[cell]))
        either = Z95 * SPREAD * shown
        change = np.zeros_like(signal_model.outputs)
        change[:, cell] = (shown - 1.0) * signal_model.outputs[:, cell]
        hidden = signal_model.by_outputs(change)[signal_model.mask[:, 1]][:, COP]
        before, _ = workspace.explained(None)
        found.append(
            Cause(
                effect="stuck_cell",
                group="load_cell",
                location=place,
                probability=1.0,
                size={"share": Size(1.0 - shown, "", (1.0 - shown - either, 1.0 - shown + either))},
                run=None,
                shrink=shrink(workspace, before, before),
                hidden_cop_mm=1e3 * float(np.linalg.norm(hidden, axis=1).mean()),
            )
        )
    return found
