"""The atlas' pictures: the truth and what each method makes of it, above maps of the errors, on one sheet a view."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.atlas.compared import MAP_BLOCK, Estimate, block_map
from nephrite.atlas.pictures import TRUTH, estimate, rendered
from nephrite.atlas.plan import Plan, View
from nephrite.atlas.store import Store
from nephrite.atlas.tables import percent
from nephrite.atlas.views import Loader
from nephrite.image import figure, write

__all__ = ["draw", "file_name"]

_WIDTH = 128
_LIMIT = 0.5
_BRIGHT = 0.8  # where the 99th percentile of the truth is shown


def file_name(view: View) -> str:
    """Return the name of a view's figure."""
    return f"{view.object}-{view.size:g}mm-{view.material}-{view.light}.png"


def draw(
    plan: Plan, store: Store, view: View, names: Sequence[str], rows: list[dict[str, Any]], folder: Path
) -> Path:
    """Write the sheet of a view, whose cells must be there, into `folder`; return its path."""
    loaded = Loader(plan.resolution).load(view)
    cells = {name: rendered(plan, store, loaded, name) for name in (TRUTH, *names)}
    truth, mask = estimate(cells[TRUTH]), cells[TRUTH]["mask"]
    of_view = {
        row["method"]: row
        for row in rows
        if (row["object"], row["size"], row["material"], row["light"])
        == (view.object, view.size, view.material, view.light)
    }
    exposure = np.log2(_BRIGHT / max(float(np.percentile(truth.mean[mask], 99)), 1e-6))
    images: list[NDArray | figure.HeatMap] = [truth.mean.astype(np.float32)]
    labels, captions = [TRUTH], ["the truth"]
    for name in names:
        row = of_view[name]
        images.append(estimate(cells[name]).mean.astype(np.float32))
        labels.append(name.replace("_", " "))
        captions.append(
            f"error {percent(row['error'], row['error_error'])} %, mean {100 * row['bias']:+.0f} %"
        )
    noisy = Estimate(truth.mean + truth.noise_of_blocks(MAP_BLOCK), truth.error)
    images.append(figure.heat_map(block_map(noisy, truth, mask), _LIMIT))
    labels.append("noise of the truth")
    captions.append("standard error")
    for name in names:
        images.append(figure.heat_map(block_map(estimate(cells[name]), truth, mask), _LIMIT))
        labels.append(f"{name.replace('_', ' ')} less truth")
        captions.append(f"worst block {100 * of_view[name]['worst']:+.0f} %")
    sheet = figure.side_by_side(
        images, labels, str(view), captions, columns=1 + len(names), width=_WIDTH, exposure=float(exposure)
    )
    folder.mkdir(parents=True, exist_ok=True)
    return write.save(folder / file_name(view), sheet, {"view": str(view)})
