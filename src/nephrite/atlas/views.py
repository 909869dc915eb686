"""The scenes of the atlas' pictures, loaded one at a time, and how thick their objects are to light."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nephrite import materials
from nephrite.atlas.plan import View
from nephrite.scene import build, meshes, named
from nephrite.scene.translucent import object_mask

if TYPE_CHECKING:
    from nephrite.physics import Medium
    from nephrite.scene.triangles import TriangleMesh

__all__ = ["LIGHTS", "Loaded", "Loader"]

LIGHTS = {"side": (-1.9, 0.9, 0.5), "back": (0.4, 1.2, -1.8)}
"""Where the only light is, in units of the object's size: one square softbox, without floor or sky.

It is as large as the object is far from it, nearly, so that the exact walk, which meets it by chance, is not too noisy.
"""

_HALF_SIDE = 1.2


class Loaded:
    """A view of a resolution (width, height), whose Mitsuba scene is loaded when it is first asked for."""

    def __init__(self, view: View, mesh: TriangleMesh, resolution: tuple[int, int]) -> None:
        """Keep what the scene is made of."""
        self.view, self.mesh, self.resolution = view, mesh, resolution

    @property
    def medium(self) -> Medium:
        """What the object is made of."""
        return materials.find(self.view.material).medium

    @property
    def thickness(self) -> NDArray[np.float64]:
        """Mean chord of the object, 4 V / S (Cauchy), in reduced mean free paths: one value a channel."""
        placed = meshes.placed(self.mesh, self.view.size)
        return 4.0 * placed.volume / placed.area * np.array(self.medium.sigma_t_prime)

    @cached_property
    def scene(self) -> Any:
        """The Mitsuba scene; a variant must be set."""
        import mitsuba as mi

        view = self.view
        described = build.scene_dict(
            self.mesh, view.material, view.size, light="environment", resolution=self.resolution
        )
        turn = mi.ScalarTransform4f()
        height = float(meshes.placed(self.mesh, view.size).extents[1])
        origin = [view.size * x for x in LIGHTS[view.light]]
        place = turn.look_at(origin=origin, target=[0.0, 0.5 * height, 0.0], up=[0, 1, 0])
        del described["environment"]
        described["light"] = {
            "type": "rectangle",
            "to_world": place @ turn.scale(_HALF_SIDE * view.size),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        }
        return mi.load_dict(described, **build.LOADING)

    @cached_property
    def mask(self) -> NDArray[np.bool_]:
        """The object's pixels, (height, width)."""
        return object_mask(self.scene)


class Loader:
    """Makes views; reads each mesh once."""

    def __init__(self, resolution: tuple[int, int]) -> None:
        """Set the resolution (width, height) of all pictures."""
        self.resolution = resolution
        self._meshes: dict[str, TriangleMesh] = {}

    def load(self, view: View) -> Loaded:
        """Return the view, not yet rendered. Errors as `nephrite.scene.named.find`."""
        if view.object not in self._meshes:
            self._meshes[view.object] = named.find(view.object)
        return Loaded(view, self._meshes[view.object], self.resolution)
