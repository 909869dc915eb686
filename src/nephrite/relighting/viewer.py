"""A scene in front of a camera whose lights may move: a picture in a fraction of a second."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.errors import VariantError, unknown_name
from nephrite.plugins import collector
from nephrite.plugins.lookup import Lookup
from nephrite.plugins.media import Media
from nephrite.relighting import precomputed
from nephrite.relighting.arrivals import Arrived, Gather
from nephrite.relighting.exchange import Exchange
from nephrite.relighting.matrices import thinned
from nephrite.relighting.once import scattered_once
from nephrite.relighting.precomputed import Precomputed
from nephrite.relighting.stage import Stage
from nephrite.relighting.surroundings import Surroundings
from nephrite.relighting.view import View

FIRST_TURNS = 16  # of an environment: its light comes from all sides
_DROPPED = 1e-3  # share of single scattering at a node that may be taken for what comes from elsewhere


class Viewer:
    """Shows a scene again and again, with transport in place; see `frame`.

    Objects, their media and all that does not shine stay as they were when the viewer was made; lights may move and
    change (`lights`), and so may the camera. Only `rgb` variants.
    """

    @collector.kept_off()
    def __init__(
        self, scene: Any, transport: Precomputed | str | os.PathLike | None = None, *, walks: int = 1_500_000,
        sensor: int = 0,
    ) -> None:  # fmt: skip
        """Prepare all that does not depend on the lights.

        Args:
            scene: A Mitsuba scene.
            transport: What `precompute` or `load` has returned, or a file; it is precomputed if there is none.
            walks: For each object, if it is to be precomputed.
            sensor: Which of the scene's.

        Raises:
            ParameterError: A part of the scene that a viewer does not show, or a transport of another scene.
            VariantError: The variant is not one of `rgb`.
        """
        if not mi.is_rgb or mi.is_polarized:
            raise VariantError(f"a viewer runs in rgb variants, such as llvm_ad_rgb, not in {mi.variant()}.")
        self._stage = Stage(scene)
        self._members = precomputed.surfaces(scene)
        if transport is None:
            transport = precomputed.precompute(scene, walks)
        elif not isinstance(transport, Precomputed):
            transport = precomputed.load(transport)
        transport.check(self._members)
        self.transport = transport
        self._sensor, self._media = scene.sensors()[sensor], Media.of(scene)
        with dr.suspend_grad():
            self._lookup = Lookup(self._members, transport.layouts)
            self._surroundings = Surroundings(self._stage.solid, self._lookup, self._members)
            everywhere = np.arange(len(self._lookup.points))
            once = scattered_once(self._stage.solid, self._lookup, self._members, everywhere)
            self._exchange = Exchange(
                transport.operators, self._lookup, self._surroundings, self._members, once
            )
        self._camera = b""
        self._states: dict[str, bytes] = {}
        self._arrived: dict[str, tuple[Arrived, int]] = {}
        self.seconds: dict[str, float] = {}

    @property
    def lights(self) -> dict[str, Any]:
        """Mitsuba's parameters of each light, by its name; change them, call their `update()`, and then `frame`."""
        return {name: lamp.parameters for name, lamp in self._stage.lamps.items()}

    def light(self, name: str) -> Any:
        """Return the parameters of one light; raises `ParameterError` for an unknown name."""
        if name not in self._stage.lamps:
            raise unknown_name("light", name, self._stage.lamps)
        return self._stage.lamps[name].parameters

    def save(self, path: str | os.PathLike) -> None:
        """Write the transport into a file, from which another viewer takes it."""
        self.transport.save(path)

    @collector.kept_off()
    def frame(self) -> NDArray[np.float32]:
        """Return the picture, [height, width, 3], linear light, under the lights as they are now.

        Lights that have changed since the last frame are sampled anew, by the same few points each time; where none
        has, further points are added to those of the frames before, and the picture gets better.
        """
        with dr.suspend_grad():
            self._look()
            total = self._gather()
            return self._show(total)

    def _look(self) -> None:
        """Find what the camera sees, if it has moved."""
        start = time.perf_counter()
        digest = _state(self._sensor)
        if digest != self._camera:
            solid, lookup, around = self._stage.solid, self._lookup, self._surroundings
            self.view = View(solid, self._sensor, lookup, around, self.transport.layouts, self._media)
            seen = np.flatnonzero(np.diff(self.view.nodes.tocsc().indptr))
            once = scattered_once(solid, lookup, self._members, seen, self.view.toward)
            self._once = thinned(once, _DROPPED)
            self._toward = np.conj(self._exchange.tangential(self.view.toward.T))
            self._gathering = Gather(solid, lookup, around, self.view)
            self._camera = digest
            self._states, self._arrived = {}, {}
        self.seconds["camera"] = time.perf_counter() - start

    def _gather(self) -> Arrived:
        """Return what arrives from all lights."""
        start = time.perf_counter()
        for lamp in self._stage.lamps.values():
            lamp.settle()
        states = {name: lamp.state() for name, lamp in self._stage.lamps.items()}
        changed = [name for name in states if states[name] != self._states.get(name)]
        for name in changed or states:
            lamp = self._stage.lamps[name]
            if name in changed:
                turns = FIRST_TURNS if lamp.emitter.is_environment() else 1
                arrived, count = self._gathering.turn(lamp, 0), 1
            else:
                turns, (arrived, count) = 1, self._arrived[name]
                turns += count
            while count < turns:
                more = self._gathering.turn(lamp, count)
                arrived, count = arrived * (count / (count + 1)) + more * (1 / (count + 1)), count + 1
            self._arrived[name] = arrived, count
        self._states = states
        first, *others = (arrived for arrived, _ in self._arrived.values())
        for other in others:
            first = first + other
        self.seconds["lights"] = time.perf_counter() - start
        return first

    def _show(self, arrived: Arrived) -> NDArray[np.float32]:
        """Return the picture that comes of what arrives."""
        start = time.perf_counter()
        picture = np.empty((self.view.pixels, 3), np.float32)
        with ThreadPoolExecutor(3) as pool:  # sparse products run beside each other
            for c, channel in enumerate(pool.map(lambda c: self._channel(arrived, c), range(3))):
                np.maximum(channel, 0, out=picture[:, c])
        self.seconds["picture"] = time.perf_counter() - start
        return picture.reshape(self.view.height, self.view.width, 3)

    def _channel(self, arrived: Arrived, c: int) -> NDArray[np.float32]:
        """Return one channel of it, [pixels]: light goes where it does in the scene, and then to the eye."""
        view, sent = self.view, self._exchange.sent(arrived, c)
        shown = sent.mean + np.real(self._toward * sent.directed)
        shown += self._once[c] @ sent.shallow
        picture = arrived.picture[c] + view.shown[c] @ np.concatenate([shown, sent.x])
        if view.seen is not None:
            points = view.mean @ (arrived.points[c] + view.seen @ sent.x)
            picture[view.pixel] += view.reflects[c] * points
        return picture


def _state(sensor: Any) -> bytes:
    """Return what a camera's picture depends on."""
    values = [getattr(value, "matrix", value) for _, value in mi.traverse(sensor)]
    return b"".join(np.ascontiguousarray(np.array(value)).tobytes() for value in values)
