"""The pictures of a comparison: rendered, and laid out with maps and numbers of the differences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nephrite.cli import picture

if TYPE_CHECKING:
    from nephrite.cli.job import Settings, Subject
    from nephrite.rendering.result import Result


@dataclass(frozen=True)
class Panel:
    """One picture of a comparison.

    Attributes:
        label: What sets it apart.
        result: The picture as rendered, which the numbers are about.
        shown: (height, width, 3) what is shown: denoised, if that was wanted.
        mask: (height, width) the object's pixels.
    """

    label: str
    result: Result
    shown: NDArray[np.float32]
    mask: NDArray[np.bool_]


@dataclass(frozen=True)
class Difference:
    """How a panel differs from the reference, over the object's pixels.

    Attributes:
        mean: Relative difference of the means, signed, averaged over the channels that have light.
        relmse: Relative mean squared error, noise included.
    """

    mean: float
    relmse: float

    def __str__(self) -> str:
        """Return both in words."""
        return f"mean {self.mean:+.1%}, relMSE {self.relmse:.3g}"


def variations(base: Settings, lists: Mapping[str, Sequence[str]]) -> dict[str, Settings]:
    """Return `base` with every combination of the values in `lists` (setting: values), by label."""
    combinations = product(*lists.values())
    found = {
        ", ".join(values): replace(base, **dict(zip(lists, values, strict=True))) for values in combinations
    }
    models = {one.model for one in found.values()}
    return {label: one.apart_from(models) for label, one in found.items()}


def rendered(subject: Subject, settings: Settings, label: str, denoise: bool) -> Panel:
    """Render one panel, denoised for showing if asked for and possible."""
    from nephrite.scene.translucent import object_mask

    scene = subject.scene(settings)
    result = picture.rendered(scene, settings, label)
    clean = picture.denoised(scene, result) if denoise and not result.interrupted else None
    return Panel(label, result, result.pixels if clean is None else clean, object_mask(scene))


def differences(panels: Sequence[Panel], reference: Panel) -> list[Difference]:
    """Return how the panels, as rendered, differ from the reference."""
    from nephrite.image import errors

    found = []
    for panel in panels:
        mask = reference.mask if reference.mask.any() else None
        pair = panel.result.pixels, reference.result.pixels
        bias = errors.mean_bias(*pair, mask=mask)
        lit = bias[np.isfinite(bias)]
        found.append(Difference(float(lit.mean()) if lit.size else np.nan, errors.relmse(*pair, mask=mask)))
    return found


def laid_out(panels: Sequence[Panel], reference: Panel, title: str, exposure: float) -> NDArray[np.uint8]:
    """Return a uint8 figure: the panels above, their differences from `reference` below."""
    from nephrite.image import errors, figure

    maps = [errors.difference(panel.shown, reference.shown) for panel in panels]
    limit = figure.heat_map(
        np.concatenate([m for m, panel in zip(maps, panels, strict=True) if panel is not reference])
    ).limit
    blank = np.full((*reference.mask.shape, 3), figure.BACKGROUND, np.uint8)
    below = [
        blank if panel is reference else figure.heat_map(values, limit)
        for panel, values in zip(panels, maps, strict=True)
    ]
    return figure.side_by_side(
        [*(panel.shown for panel in panels), *below],
        [panel.label for panel in panels]
        + [
            "(the reference)" if panel is reference else f"{panel.label} against {reference.label}"
            for panel in panels
        ],
        title,
        [picture.summary(panel.result) for panel in panels]
        + [
            "" if panel is reference else f"over the object: {difference}"
            for panel, difference in zip(panels, differences(panels, reference), strict=True)
        ],
        columns=len(panels),
        exposure=exposure,
    )
