"""When a progressive render ends, and how fast it goes."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

from nephrite.rendering.accumulate import Accumulator

MAX_SPP = 2**16
"""Samples per pixel at which a render that waits for a noise gives up, if `spp` sets no other limit."""

DARK_SPP = 64
"""Samples per pixel after which a render that waits for a noise gives up if there is no light at all."""

NOISE_PASSES = 4
"""Passes that must have been made before a noise is believed."""


@dataclass
class Goal:
    """When to stop: at so many samples per pixel, seconds, or so little noise; None is never."""

    spp: int | None
    time_s: float | None
    noise: float | None

    @property
    def most_spp(self) -> float:
        """Samples per pixel that end the render whatever else holds."""
        if self.spp is not None:
            return self.spp
        return math.inf if self.noise is None else MAX_SPP

    def reached(self, seen: Accumulator, seconds: float, noise: float) -> str:
        """Return the reason to stop, empty to go on."""
        if self.noise is not None:
            if noise <= self.noise and seen.passes >= NOISE_PASSES:
                return "noise"
            if math.isinf(noise) and seen.passes >= NOISE_PASSES and seen.spp >= DARK_SPP:
                return "dark"
        if seen.spp >= self.most_spp:
            return "spp" if self.spp is not None else "cap"
        return "time" if self.time_s is not None and seconds >= self.time_s else ""

    def wanted_spp(self, seen: Accumulator, noise: float) -> float:
        """Return the spp in all that the noise, which falls with their square root, and the limit ask for."""
        if self.noise is None or math.isinf(noise) or seen.passes < NOISE_PASSES:
            return self.most_spp
        return min(self.most_spp, math.ceil(seen.spp * (noise / self.noise) ** 2))


@dataclass
class Clock:
    """Measures the passes; the first one is not typical, because the kernels are compiled in it."""

    start: float = field(default_factory=time.perf_counter)
    laps: list[tuple[float, int]] = field(default_factory=list)

    def seconds(self) -> float:
        """Return the time since the start."""
        return time.perf_counter() - self.start

    def seconds_per_spp(self) -> float | None:
        """Return the recent rate, None before two passes."""
        if len(self.laps) < 2:
            return None
        recent = self.laps[max(1, len(self.laps) // 2) :]
        return sum(lap for lap, _ in recent) / sum(spp for _, spp in recent)
