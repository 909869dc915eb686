"""One walk for all colour channels: which channel leads it, and how the others weigh in.

A walk draws its distances for one channel, chosen with probability q. Every channel keeps `β`, its throughput
divided by the leader's density, and `ratio`, its own density times its q divided by the leader's. The balance
heuristic over channels (spectral multiple importance sampling, Wilkie et al. 2014) then weighs the walk by
`β / sum(ratio)`, which never exceeds the greatest of the throughputs before the walk over their q.

Light goes farther in a clear channel than in a dense one, meets more different lights, and is noisier, while its walks
have fewer events: q follows the throughput over the square root of the extinction.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

CLEAREST = 1 / 16  # of the densest channel's extinction: clearer channels count as this


def pick(values: Any, channel: Any) -> Any:
    """Value of the leading channel."""
    result = values[0]
    for i in range(1, len(values)):
        result = dr.select(channel == i, values[i], result)
    return result


def lead(β: Any, sigma_t: Any, u: Any) -> tuple[Any, Any, Any]:
    """Choose the leader of a walk with the throughput `β` where it enters; return (channel, β, ratio)."""
    density = dr.clip(sigma_t / dr.maximum(dr.max(sigma_t), 1e-30), CLEAREST, 1.0)
    chances = β * dr.rsqrt(density)
    total = dr.sum(chances)
    target, below, channel = u * total, mi.Float(0.0), mi.UInt32(0)
    for i in range(len(β) - 1):
        below += chances[i]
        channel = dr.select(target >= below, i + 1, channel)
    q = chances / dr.maximum(total, 1e-30)
    of_leader = dr.maximum(pick(q, channel), 1e-30)
    return channel, β / of_leader, q / of_leader


def solo(β: Any) -> Any:
    """Ratios of a path that is in no medium: `β / sum(ratio)` is `β`."""
    return mi.Spectrum(1.0 / len(β))
