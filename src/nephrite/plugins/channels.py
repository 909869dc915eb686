"""One walk for all colour channels: which channel leads it, and how the others weigh in.

A walk draws its distances for one channel, chosen with probability q. Every channel keeps `β`, its throughput
divided by the leader's density, and `ratio`, its own density times its q divided by the leader's. The balance
heuristic over channels (spectral multiple importance sampling, Wilkie et al. 2014) then weighs the walk by
`β / sum(ratio)`, which never exceeds the throughput before the walk by more than the number of channels, and by no
more than their sum if q follows the throughput.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi


def pick(values: Any, channel: Any) -> Any:
    """Value of the leading channel."""
    result = values[0]
    for i in range(1, len(values)):
        result = dr.select(channel == i, values[i], result)
    return result


def lead(β: Any, u: Any) -> tuple[Any, Any, Any]:
    """Choose the leader of a walk in proportion to the throughput `β`; return (channel, β, ratio)."""
    count = len(β)
    total = dr.sum(β)
    target, below, channel = u * total, mi.Float(0.0), mi.UInt32(0)
    for i in range(count - 1):
        below += β[i]
        channel = dr.select(target >= below, i + 1, channel)
    q = β / dr.maximum(total, 1e-30)
    of_leader = dr.maximum(pick(q, channel), 1e-30)
    return channel, β / of_leader, q / of_leader


def solo(β: Any) -> Any:
    """Ratios of a path that is in no medium: `β / sum(ratio)` is `β`."""
    return mi.Spectrum(1.0 / len(β))
