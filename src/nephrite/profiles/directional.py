"""The directional dipole of Frisvad, Hachisuka and Kjeldsen (2014): a ray source in place of a point source.

It is not radial, and has a contract of its own. For light that enters at x_i, where the normal is n_i, from the
direction w_i, and leaves at x_o, where it is n_o, in the direction w_o, a model has

- `exitance(x_i, n_i, w_i, x_o, n_o, w_o)`: light that leaves per area (1/length^2) and per light that has *entered*:
  what R(r) is for a radial profile;
- `eval(x_i, n_i, w_i, x_o, n_o, w_o)`: the BSSRDF S, 1/(length^2 sr): radiance that leaves per light that *arrives*. It
  has both transmittances: `S = (1 - F(w_i)) exitance (1 - F(w_o)) / (c pi)`, c = `lobe_normalization(eta)`.

Points and vectors are Dr.Jit vectors (`Array3f`, `mi.Vector3f`, `mi.Point3f`) or NumPy arrays [..., 3] that broadcast;
directions and normals have length 1; w_i points to where the light comes from, w_o to where it goes, n_i and n_o
outwards. Coefficients are numbers or arrays of the shape [...]. Light from below the surface gives 0. Everything is
differentiable with Dr.Jit in points, directions, coefficients, eta and g. Both stand for light that has scattered at
least once and left its direction: the paper adds the rest, delta-Eddington's reduced beam. A plane sends out too much:
under normal light 3.5, 2.0, 1.5, 1.3 and 1.3 times what it should for albedo' .5 .8 .95 .99 .999 at eta = 1.3, and 1.24
times what enters without absorption. The source of the published formula has the light's power, whatever the albedo.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nephrite.physics._arrays import namespace, plain, root
from nephrite.physics._lift import alike, checked
from nephrite.physics.fresnel import c1, c2, check_eta, lobe_normalization, reflectance
from nephrite.physics.phase import check_g
from nephrite.profiles._poles import LEAST_EXTINCTION

__all__ = ["DirectionalDipole", "ReciprocalDirectionalDipole"]

_CLOSEST = 1e-3  # reduced mean free paths: nothing is nearer to a source than that


class DirectionalDipole:
    """The plain model: a function of the direction of the light that enters, not of the one that leaves.

    `sigma_a`, `sigma_s_prime`: absorption and reduced scattering (1/length); `eta`: inside / outside, `g`: mean cosine,
    numbers or Dr.Jit arrays of one entry. Raises `ParameterError` for a bad `eta` or `g`.
    """

    def __init__(self, sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> None:
        """Derive the coefficients (Frisvad et al. 2014, sections 3 and 4; the distance `de` is their equation 21)."""
        self.eta, g = checked(check_eta, eta), checked(check_g, g)
        sigma_a = alike(sigma_a, eta, g)
        xp = namespace(sigma_a, sigma_s_prime)
        sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
        albedo_prime = sigma_s_prime / sigma_t_prime
        self.scatters = plain(xp.select(sigma_s_prime > 0.0, 1.0, 0.0))
        self.diffusion = plain(1.0 / (3.0 * sigma_t_prime))
        self.sigma_tr = plain(xp.sqrt(3.0 * sigma_a) * xp.sqrt(sigma_t_prime))
        self.extrapolated = plain(2.131 * self.diffusion / xp.sqrt(xp.maximum(albedo_prime, 1e-6)))
        self.behind = plain(1.0 / (3.0 * xp.maximum(sigma_a + sigma_s_prime / (1.0 - g), LEAST_EXTINCTION)))
        self.of_fluence = plain(0.25 * (1.0 - 2.0 * c1(eta)))
        self.of_flux = plain(0.5 * (1.0 - 3.0 * c2(eta)))
        self.boundary = plain((1.0 - self.of_flux) / (2.0 * self.of_fluence))

    def exitance(self, x_i: Any, n_i: Any, w_i: Any, x_o: Any, n_o: Any, w_o: Any = None) -> Any:
        """Light that leaves at x_o per area and per light that has entered at x_i; see the module's text."""
        x_i, n_i, w_i, x_o, n_o = (_components(v) for v in (x_i, n_i, w_i, x_o, n_o))
        beam = self._refracted(n_i, w_i)
        x = _combined(x_o, -1.0, x_i)
        squared = _dot(x, x)
        xp = namespace(squared, self.sigma_tr)

        # the real source is a ray that bends the surface's distance: shorter in front of it than behind
        outwards = -_dot(n_o, beam)
        along = _dot(x, beam)
        extrapolated, diffusion = self.extrapolated, self.diffusion
        spread = xp.maximum(squared - along * along, 0.0) / (squared + extrapolated * extrapolated)
        lit = diffusion * outwards * (diffusion * outwards + 2.0 * extrapolated * root(spread))
        real = squared + xp.select(outwards > 0.0, lit, self.behind * self.behind)

        # the virtual one is its mirror image in the plane through x_i and x_o that is nearest to the tangent plane
        mirror = self._modified_normal(n_i, x, squared)
        height = 2.0 * self.boundary * extrapolated
        from_image = _combined(x, -height, mirror)
        image_beam = _combined(beam, -2.0 * _dot(beam, mirror), mirror)
        value = self._source(x, beam, n_o, real)
        value = value - self._source(from_image, image_beam, n_o, _dot(from_image, from_image))
        return plain(self.scatters * (xp.maximum(value, 0.0) * (1.0 / (4.0 * math.pi))))

    def eval(self, x_i: Any, n_i: Any, w_i: Any, x_o: Any, n_o: Any, w_o: Any) -> Any:
        """S: radiance that leaves at x_o along w_o per light that arrives at x_i from w_i."""
        cos_i = _dot(_components(n_i), _components(w_i))
        cos_o = _dot(_components(n_o), _components(w_o))
        value = self.exitance(x_i, n_i, w_i, x_o, n_o, w_o)
        xp = namespace(value, cos_i, cos_o, self.eta)
        enters = xp.select(cos_i > 0.0, 1.0 - reflectance(cos_i, self.eta), 0.0)
        leaves = xp.select(cos_o > 0.0, 1.0 - reflectance(cos_o, self.eta), 0.0)
        return plain(enters * value * leaves / (math.pi * lobe_normalization(self.eta)))

    def _refracted(self, n: Any, w: Any) -> Any:
        """Direction in which light from w travels inside; along the surface where it is totally reflected."""
        cosine = _dot(n, w)
        xp = namespace(cosine, self.eta)
        inside = 1.0 - (1.0 - cosine * cosine) / (self.eta * self.eta)
        along = cosine / self.eta - root(xp.maximum(inside, 0.0))
        return _combined(tuple(part * along for part in n), -1.0 / self.eta, w)

    def _modified_normal(self, n: Any, x: Any, squared: Any) -> Any:
        """Normalised part of n at right angles to x (equation 23); n itself where there is none."""
        xp = namespace(squared)
        along = _dot(n, x) / xp.maximum(squared, 1e-30)
        part = _combined(n, -along, x)
        length = _dot(part, part)
        usable = (length > 1e-8) & (squared > 1e-24)
        factor = 1.0 / xp.sqrt(xp.select(usable, length, 1.0))
        return tuple(xp.select(usable, factor * a, b) for a, b in zip(part, n, strict=True))

    def _source(self, x: Any, beam: Any, n: Any, squared: Any) -> Any:
        """Flux and fluence that a ray source sends out at a distance: their equation 17 without `4 pi^2` and `4 C`."""
        xp = namespace(squared, self.sigma_tr)
        squared = xp.maximum(squared, (3.0 * _CLOSEST * self.diffusion) * (3.0 * _CLOSEST * self.diffusion))
        distance = xp.sqrt(squared)
        falloff = self.sigma_tr * distance
        along, outwards, up = _dot(x, beam), _dot(beam, n), _dot(x, n)
        slope = 1.0 + falloff
        fluence = squared / self.diffusion + 3.0 * slope * along
        curved = slope + 3.0 * self.diffusion * (3.0 * slope + falloff * falloff) / squared * along
        flux = 3.0 * self.diffusion * slope * outwards - curved * up
        decay = xp.exp(-falloff) / (squared * distance)
        return decay * (self.of_fluence * fluence - self.of_flux * flux)


class ReciprocalDirectionalDipole(DirectionalDipole):
    """The model made reciprocal (Frisvad et al. 2014, section 6.3): the mean of both ways that light can take."""

    def exitance(self, x_i: Any, n_i: Any, w_i: Any, x_o: Any, n_o: Any, w_o: Any = None) -> Any:
        """Mean of the plain model's exitance from i to o and from o, where light would arrive from w_o, to i."""
        there = super().exitance(x_i, n_i, w_i, x_o, n_o)
        back = super().exitance(x_o, n_o, w_o, x_i, n_i)
        return plain(0.5 * (there + back))


def _components(vector: Any) -> tuple[Any, Any, Any]:
    if isinstance(vector, np.ndarray | list | tuple):
        vector = np.asarray(vector, dtype=np.float64)
        return vector[..., 0], vector[..., 1], vector[..., 2]
    return vector[0], vector[1], vector[2]


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _combined(a: Any, factor: Any, b: Any) -> tuple[Any, Any, Any]:
    """Return a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]
