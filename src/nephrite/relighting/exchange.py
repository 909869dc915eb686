"""What light does that has arrived at a scene, whatever the camera: it goes between surfaces, and through objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from nephrite.relighting.arrivals import Arrived
from nephrite.relighting.matrices import beside
from nephrite.relighting.surroundings import Surroundings, interreflection
from nephrite.transport.pyramid import Pyramid, averaging


@dataclass
class Sent:
    """What comes of it in one channel, at nodes and stations.

    `mean`, `directed`: what has been scattered twice or more, as a mean over directions and tangential vectors;
    `shallow`: what arrives, as single scattering takes it; `x`: what nodes send out (see `surroundings`), and then
    the radiance of stations.
    """

    mean: NDArray
    directed: NDArray
    shallow: NDArray
    x: NDArray


class Exchange:
    """The operators of it, between the nodes and stations of a scene."""

    def __init__(
        self, operators: list[Pyramid], lookup: Any, surroundings: Surroundings, members: list[tuple[Any, Any]],
        once: list[Any],
    ) -> None:  # fmt: skip
        """Hold the transport of each object; `once`: what nodes send out after one event, [nodes, nodes] a channel."""
        self._around = surroundings
        self._operators = [(operator, lookup.own(i)) for i, operator in enumerate(operators)]
        self._once_sent = np.stack([np.asarray(matrix.sum(axis=1)).ravel() for matrix in once])
        kept = [1.0 - entry.single_share for entry, _ in members]
        # the share of light that scatters again after one event
        self._kept = np.repeat(kept, np.diff(lookup.firsts)).astype(np.float32)
        self._albedo = np.ascontiguousarray(surroundings.albedo.T)
        self._from_stations = beside(surroundings.from_stations.nodes, surroundings.from_stations.stations)
        self._coarse(operators, once)

    def _coarse(self, operators: list[Pyramid], scattered_once: list[Any]) -> None:
        """Prepare what comes of light that goes from object to object, or over stations and back."""
        up = sparse.block_diag([operator.up(len(operator.ups)) for operator in operators], "csr")
        down = averaging(up)
        transport = [
            linalg.block_diag(*parts) for parts in zip(*(o.coarse() for o in operators), strict=True)
        ]
        around = self._around
        once = [(down @ matrix @ up).toarray() for matrix in scattered_once]
        direct = down @ around.from_nodes.nodes @ up
        again = []
        for c in range(3):
            over = sparse.diags(around.albedo[:, c]) @ (around.from_stations.nodes @ up)
            again.append((direct + (down @ around.from_nodes.stations) @ over).toarray())
        self._cells = np.cumsum([operator.ups[-1].shape[1] for operator in operators])[:-1]
        self._further = interreflection([a + b for a, b in zip(transport, once, strict=True)], again)

    def tangential(self, vectors: NDArray) -> NDArray:
        """Return what is tangential at the nodes of vectors, [3, nodes]: see `Pyramid.tangential`."""
        return np.concatenate([operator.tangential(vectors[:, own]) for operator, own in self._operators])

    def sent(self, arrived: Arrived, c: int) -> Sent:
        """Return what comes of what has arrived: light goes to stations, between surfaces, and through objects."""
        operators, albedo = self._operators, self._albedo[c]
        mean, vectors = arrived.nodes[c, 0], arrived.nodes[c, 1:]
        radiance = albedo * arrived.stations[c]
        more = self._around.from_nodes.stations @ radiance
        once = mean + more
        averages = np.concatenate([operator.averaged(once[own]) for operator, own in operators])
        # not `@`: BLAS would do it in threads, which then wait in a loop for more, and take the other core's time
        further = np.einsum("ij,j->i", self._further[c], averages)
        cells = np.split(further, self._cells)
        more += np.concatenate([o.interpolated(part) for (o, _), part in zip(operators, cells, strict=True)])
        arriving = mean + more
        carried = [
            operator.carried(arriving[own], operator.tangential(vectors[:, own]), c)
            for operator, own in operators
        ]
        seen, directed = (np.concatenate(parts) for parts in zip(*carried, strict=True))
        shallow = (arrived.plain[c] - self._kept * mean) / (1 - self._kept) + more
        x = np.concatenate([seen + self._once_sent[c] * shallow, radiance])
        x[len(seen) :] += albedo * (self._from_stations @ x)
        return Sent(seen, directed, shallow, x)
