"""What a progressive render reports while it runs, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Progress:
    """The state of a render after a pass.

    Attributes:
        spp: Samples per pixel so far.
        target: Samples per pixel at the end: given, or estimated from the time or the noise; None if unknown.
        seconds: Wall-clock time so far.
        remaining_s: Estimate of the time left; None if unknown (the first pass compiles as well).
        noise: Relative noise reached (`Result.noise`); infinite as long as it is unknown.
        passes: Passes so far.
        fraction: Share of the work that is done, in [0, 1].
    """

    spp: int
    target: int | None
    seconds: float
    remaining_s: float | None
    noise: float
    passes: int
    fraction: float


@dataclass(frozen=True)
class Result:
    """A picture and how it came about.

    Attributes:
        pixels: (height, width, 3) float32 linear light: the mean over all samples.
        variance: (height, width, 3) float32, variance of that mean (not of a sample), estimated from the
            differences between passes; infinite if a pixel has fewer than two passes.
        noise: Root mean square, over the lit pixels, of standard error / (radiance + 5 % of the median of the
            lit pixels' radiance): the relative error, without dark pixels deciding. Infinite before there are
            two passes, and without light.
        spp: Samples per pixel.
        seconds: Wall-clock time, compilation included.
        passes: Number of passes.
        interrupted: True if Ctrl-C ended it before its time.
        stopped: Why it ended: `spp`, `time`, `noise`, `cap`, `dark` or `interrupted`.
        dropped: Pixel values that were NaN or infinite and left out, over all passes.
        seed: Seed that it was started with.
        notes: Messages for people: dropped values, a cap that was reached, a picture without light.
    """

    pixels: NDArray[np.float32]
    variance: NDArray[np.float32]
    noise: float
    spp: int
    seconds: float
    passes: int
    interrupted: bool
    stopped: str
    dropped: int
    seed: int
    notes: tuple[str, ...] = ()
