"""The levers that make walks and transport fast, and how each is taken away again.

A lever is taken away in a process of its own, before anything is rendered: kernels are recorded with what is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.plugins import (
    camera,
    channels,
    glints,
    guide,
    path,
    roulette,
    sequence,
    transport,
    twin,
    walked,
)

WALK, TRANSPORT = "walk", "transport"
_NEVER = 1e9


@dataclass(frozen=True)
class Lever:
    """Something that was done for speed.

    `title`: what it is; `instead`: what is done without it, by calling `take_away`; `settings`: the integrator's, for
    what is a parameter.
    """

    name: str
    title: str
    instead: str
    take_away: Callable[[], None] = lambda: None
    settings: tuple[tuple[str, Any], ...] = ()


def _one_path_a_lane() -> None:
    camera.PATHS_PER_LANE = 1


def _one_channel() -> None:
    lead = channels.lead

    def alone(β: Any, sigma_t: Any, u: Any) -> tuple[Any, Any, Any]:
        channel, of_leader, _ = lead(β, sigma_t, u)
        led = mi.Spectrum(*[dr.select(channel == i, mi.Float(1), 0) for i in range(len(of_leader))])
        return channel, of_leader * led, led

    channels.lead = alone


def _by_chance() -> None:
    def number(self: Any, dimension: int, index: Any, otherwise: Any, first: Any = True) -> Any:
        random = mi.sample_tea_float32(self._moved[dimension], mi.UInt32(self.turn + self.turns * index))
        return dr.select(first, random, otherwise)

    sequence.OfPixels.__call__ = number


def _no_turns() -> None:
    guide.SHARE = 0.0


def _no_lamps() -> None:
    glints._MOST = 0


def _one_connection() -> None:
    path.connection_count = lambda scene: 1


def _all_shadow_rays() -> None:
    def traced(scene: Any, at: Any, ds: Any, value: Any, active: Any) -> Any:
        return dr.select(scene.ray_test(at.spawn_ray_to(ds.p), active), 0, value)

    path.unblocked = traced


def _no_thinning() -> None:
    roulette.ORDER = _NEVER


def _every_walk() -> None:
    roulette.entering = lambda worth, of_camera, depth: mi.Float(1)


def _no_twin() -> None:
    twin.expected = lambda sigma_t, sigma_s, kept: mi.Spectrum(0)
    twin.second = lambda *given: mi.Spectrum(0)


def _anywhere() -> None:
    transport.seen = lambda scene, sensor, lookup, seed: np.zeros(len(lookup.points))


def _long_walks() -> None:
    walked._ORDER = _NEVER


LEVERS: dict[str, tuple[Lever, ...]] = {
    WALK: (
        Lever("lobe", "lights are connected to at the exit, by the lobe", "they are found by chance: exit `exact`",
              settings=(("exit", "exact"),)),
        Lever("lanes", "a lane starts its next path as soon as one ends", "a lane has one path", _one_path_a_lane),
        Lever("spectral", "one walk for all channels (spectral MIS)", "a walk for one channel", _one_channel),
        Lever("sequence", "a pixel's paths begin by an even sequence", "by chance", _by_chance),
        Lever("turns", "turns toward lamps in thin parts", "turns by the phase function alone", _no_turns),
        Lever("glints", "mirrored lamps and lamps straight behind are looked at", "by chance; no turns", _no_lamps),
        Lever("connections", "every emitter is connected to", "one, by chance", _one_connection),
        Lever("shadows", "shadow rays where there is light to lose", "for each connection", _all_shadow_rays),
        Lever("thinning", "long walks are thinned out", "roulette by the throughput alone", _no_thinning),
        Lever("entering", "after a bounce, walks by what they are worth", "every path begins a walk", _every_walk),
    ),
    TRANSPORT: (
        Lever("twin", "a path is compared with its twin in a half-space", "it is not", _no_twin),
        Lever("seen", "walks begin where the camera looks", "everywhere alike", _anywhere),
        Lever("long", "long walks are thinned out", "roulette by the throughput alone", _long_walks),
        Lever("sequence", "paths and walks begin by an even sequence", "by chance", _by_chance),
        Lever("glints", "mirrored lamps and lamps straight behind are looked at", "by chance; no turns", _no_lamps),
        Lever("lanes", "a lane starts its next path as soon as one ends", "a lane has one path", _one_path_a_lane),
    ),
}  # fmt: skip
