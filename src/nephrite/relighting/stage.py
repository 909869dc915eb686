"""The scene as a viewer sees it: solid things that stay, and lamps, which may move."""

from __future__ import annotations

import hashlib
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.errors import ParameterError

_BY_FORMULA = ("Cylinder", "Disk", "Rectangle", "Sphere")
"""Shapes that rays meet by a formula, sooner than by a search tree."""

_KEPT = dr.VarState.Evaluated


class Lamp:
    """One light: a shape that emits, a point, a direction, or the environment.

    `parameters`: Mitsuba's, of the shape or the emitter. After `update()` the light is there; a whole scene's
    parameters would build the scene's search tree anew.
    """

    def __init__(self, emitter: Any, shape: Any) -> None:
        """Hold the emitter, and its shape or None."""
        self.emitter, self.shape = emitter, shape
        owner = emitter if shape is None else shape
        self.name = owner.id()
        self.parameters = mi.traverse(owner)

    def state(self) -> bytes:
        """Return a digest of where it is and how it shines."""
        found = hashlib.blake2b()
        for name, value in self.parameters:
            value = getattr(value, "matrix", value)
            found.update(str(name).encode())
            found.update(np.ascontiguousarray(np.array(value)).tobytes())
        return found.digest()

    def settle(self) -> None:
        """Put what has been set into memory: as a number in kernels, it would have them compiled for each new light."""
        for name, value in self.parameters:
            if getattr(getattr(value, "matrix", value), "state", _KEPT) != _KEPT:
                dr.make_opaque(value)
                self.parameters[name] = value
        self.parameters.update()

    def sent(self, solid: Any, at: Any, u: Any) -> tuple[Any, Any]:
        """Sample what arrives at interactions: the direction to the light, and radiance over its density."""
        ds, light = self.emitter.sample_direction(at, u, True)
        ray = at.spawn_ray(ds.d) if self.emitter.is_environment() else at.spawn_ray_to(ds.p)
        arrives = (ds.pdf > 0) & (dr.dot(ds.d, at.n) * dr.dot(at.n, at.sh_frame.n) > 0)
        arrives &= ~solid.ray_test(ray, arrives)
        return ds.d, dr.select(arrives, light, 0)

    def seen(self, ray: Any) -> Any:
        """Return the radiance that comes along rays, which end where a solid thing is."""
        if self.emitter.is_environment():
            si: Any = dr.zeros(mi.SurfaceInteraction3f, dr.width(ray.d))
            si.wi = -ray.d
            return dr.select(ray.maxt == dr.largest(mi.Float), self.emitter.eval(si), 0)
        if self.shape is None:
            return mi.Spectrum(0)
        si = (self.shape if self._by_formula() else _scene([self.shape])).ray_intersect(ray)
        return dr.select(si.is_valid(), self.emitter.eval(si), 0)

    def _by_formula(self) -> bool:
        kind = self.shape.class_name()
        if kind == "Rectangle":  # Mitsuba's formula takes its sides to be at right angles
            to_world: Any = self.parameters["to_world"]
            x, y = np.array(to_world.matrix).reshape(4, 4)[:3, :2].T
            return bool(abs(x @ y) < 1e-5 * np.sqrt((x @ x) * (y @ y)))
        return kind in _BY_FORMULA


class Stage:
    """`solid`: a scene of all shapes that do not emit; `lamps`: the lights, by name."""

    def __init__(self, scene: Any) -> None:
        """Take a scene apart; raises `ParameterError` for surfaces that a viewer does not show."""
        shapes = list(scene.shapes())
        for shape in shapes:
            _check(shape)
        self.solid = _scene([shape for shape in shapes if not shape.is_emitter()])
        own = [(shape.emitter(), shape) for shape in shapes if shape.is_emitter()]
        own += [(emitter, None) for emitter in scene.emitters() if emitter.get_shape() is None]
        if not own:
            raise ParameterError("the scene has no light: add an emitter to it.")
        self.lamps = {lamp.name: lamp for lamp in (Lamp(*pair) for pair in own)}


def _scene(shapes: list[Any]) -> Any:
    """Return a scene of shapes, which keep the names that they have in another one."""
    names = [shape.id() for shape in shapes]
    described = {f"shape {i}": shape for i, shape in enumerate(shapes)}
    found = mi.load_dict({"type": "scene", **described}, optimize=False)
    for shape, name in zip(shapes, names, strict=True):
        shape.set_id(name)
    return found


def _check(shape: Any) -> None:
    bsdf = shape.bsdf()
    if shape.is_emitter() or bsdf is None or shape.interior_medium() is not None:
        return
    if "translucent" not in type(bsdf).__name__.lower() and mi.has_flag(bsdf.flags(), mi.BSDFFlags.Delta):
        raise ParameterError(
            f"shape {shape.id()!r} is a mirror or glass without a medium: a viewer shows none. Render the scene with "
            "translucent_path."
        )
