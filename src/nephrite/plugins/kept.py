"""Keeps precomputed transport between renders: T while the objects stay what they are, V while nothing else changes.

T's noise stays in the picture, however many samples it has. So T is made of the more walks the more samples are asked
for: with a walk for some samples, both have their share of the time and of the noise.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np

from nephrite.plugins.auto import Choice
from nephrite.plugins.balance import fingerprint
from nephrite.plugins.media import TRANSPORT, WALK, Media
from nephrite.plugins.transport import Transport

FEWEST_WALKS, MOST_WALKS = 3 << 18, 1 << 22
_SAMPLES = 6  # for each walk
LOST = 0.01  # of the light that enters a shape: what other objects in it may take


class Kept:
    """The transport of the scene that was rendered last."""

    def __init__(self) -> None:
        """Begin with none."""
        self._transport: Transport | None = None
        self._objects: Any = None
        self._lights: Any = None

    def prepare(
        self, settings: Any, scene: Any, media: Media, choices: list[Choice], sensor: Any, samples: int, seed: int
    ) -> list[Choice]:  # fmt: skip
        """Give `media` its transport, found anew where something has changed; return what is computed in the end.

        `samples` are to be taken of it, by `sensor`, if it is known; `seed`: for what is found anew.
        Walks are left to objects that have others inside, where light ends that transport knows nothing of.
        """
        members = [
            (number, entry, shape)
            for number, (entry, model) in enumerate(zip(media.entries, media.models, strict=True))
            if model == TRANSPORT
            for shape in entry.shapes
        ]
        if not members or not settings.multiple:
            return choices
        objects, walks = fingerprint(media), settings.walks or walks_for(samples)
        if self._transport is None or self._objects != objects or self._transport.walks < walks:
            bodies = [(entry, shape) for _, entry, shape in members]
            self._transport = Transport(scene, bodies, walks, seed, sensor)
            self._objects, self._lights = objects, None
        transport = self._transport
        transport.lookup.attach([shape for _, _, shape in members])
        blocked = {
            number
            for (number, _, _), surface in zip(members, transport.surfaces, strict=True)
            if surface.lost > LOST
        }
        if blocked:
            models = [WALK if n in blocked else model for n, model in enumerate(media.models)]
            media.set_models(models)
            reason = "another object lies inside"
            choices = [
                replace(choice, model="walk", reason=reason) if n in blocked else choice
                for n, choice in enumerate(choices)
            ]
        media.transport = transport
        lights = (settings.max_depth, settings.exit, _digest(scene))
        if self._lights != lights:
            transport.relight(settings, scene, media)
            self._lights = lights
        return choices


def walks_for(samples: int) -> int:
    """Return how many walks transport is made of for so many samples in all, pixels times spp.

    A power of two, but for the fewest: half a million walks leave blotches that are seen in a denoised picture.
    """
    power = 1 << (max(samples // _SAMPLES, 1).bit_length() - 1)
    return min(max(power, FEWEST_WALKS), MOST_WALKS)


def _digest(scene: Any) -> str:
    """Return a hash of all that can be changed in a scene, but its sensors."""
    sensors = tuple(f"{sensor.id()}." for sensor in scene.sensors())
    values = {str(name): value for name, value in mi.traverse(scene)}
    found = hashlib.blake2b()
    for name in sorted(values):
        if not name.startswith(sensors):
            value: Any = values[name]
            value = getattr(value, "matrix", value)
            found.update(name.encode())
            found.update(np.ascontiguousarray(np.array(value)).tobytes())
    return found.hexdigest()
