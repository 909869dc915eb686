"""Where paths start and where their light goes: a film whose lanes trace one path after the other.

A vectorised loop runs until the slowest of its lanes is done, and walks have long tails. So each lane takes up to
`PATHS_PER_LANE` paths of one pixel, and starts the next as soon as one ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import sequence

PATHS_PER_LANE = 64
MIN_LANES = 1 << 17


@dataclass
class Result:
    """What a wavefront brought: radiance, whether anything was hit; light in walks started, and cut, per lane."""

    L: Any
    valid: Any
    cut: Any
    started: Any


class OneRay:
    """A source of one given ray per lane."""

    repeats = False

    def __init__(self, ray: Any, active: Any) -> None:
        """Hold the rays."""
        self.first, self.active = mi.Ray3f(ray), mi.Bool(active)

    def even(self, _dimension: int, _path: Any, otherwise: Any, _first: Any) -> Any:
        """Return `otherwise`: single rays have no sequence."""
        return otherwise


class Camera:
    """The rays of a sensor, and the image block that their radiance is put into."""

    repeats = True

    def __init__(self, sensor: Any, spp: int, seed: int) -> None:
        """Lay out the lanes for `spp` samples a pixel (0: as the sensor's sampler says)."""
        self.sensor, self.film = sensor, sensor.film()
        self.film.prepare([])
        self.block = self.film.create_block()
        self.block.set_coalesce(False)
        spp = spp or sensor.sampler().sample_count()
        size = mi.ScalarVector2u(self.film.crop_size())
        self.border = 0
        if self.film.sample_border():
            self.border = self.film.rfilter().border_size()
            size += 2 * self.border
        self.size = size
        pixels = int(size[0]) * int(size[1])
        groups = max(-(-spp // PATHS_PER_LANE), min(spp, -(-MIN_LANES // pixels)))
        lanes = pixels * groups
        if lanes >= 2**32:
            raise ValueError(f"spp is {spp}: too many samples for one pass, render several and average them.")
        self.sampler = mi.load_dict({"type": "independent"})
        self.sampler.seed(seed, lanes)
        # numbers that are no part of the kernel: one serves for all of spp
        count, each, rest = (dr.opaque(mi.UInt32, n) for n in (groups, spp // groups, spp % groups))
        index = dr.arange(mi.UInt32, lanes)
        pixel = index // count
        group = index - pixel * count
        self.pixel = mi.Point2u(pixel % size[0], pixel // size[0])
        self.budget = each + dr.select(group < rest, mi.UInt32(1), mi.UInt32(0))
        self.even = sequence.OfPixels(pixel, group, count, seed)
        self.first = dr.zeros(mi.Ray3f, lanes)
        self.active = self.budget > 0

    def ray(self, sampler: Any, path: Any, active: Any) -> tuple[Any, Any, Any]:
        """Sample the camera ray of each lane's `path`; return (ray, weight, position on the film)."""
        offset = mi.Vector2f(self.film.crop_offset())
        corner = mi.Vector2f(self.pixel) - self.border + offset
        spot = corner + mi.Vector2f(*(self.even(sequence.POSITION + i, path, 0) for i in range(2)))
        crop = mi.Vector2f(self.film.crop_size())
        aperture = sampler.next_2d(active) if self.sensor.needs_aperture_sample() else mi.Point2f(0.5)
        time = mi.Float(self.sensor.shutter_open())
        if self.sensor.shutter_open_time() > 0:
            time += sampler.next_1d(active) * self.sensor.shutter_open_time()
        wavelength = sampler.next_1d(active) if mi.is_spectral else mi.Float(0.0)
        ray, weight = self.sensor.sample_ray(
            time, wavelength, mi.Point2f((spot - offset) / crop), aperture, active
        )
        position = corner if self.film.rfilter().is_box_filter() else spot
        return ray, weight, mi.Point2f(position)

    def put(self, position: Any, radiance: Any, wavelengths: Any, valid: Any, active: Any) -> None:
        """Add one path's radiance to the film; what is not finite counts as black."""
        value = dr.select(dr.all(dr.isfinite(radiance)), radiance, 0.0)
        alpha = dr.select(valid, mi.Float(1.0), mi.Float(0.0))
        flags = self.film.flags()
        if mi.has_flag(flags, mi.FilmFlags.Special):
            values = self.film.prepare_sample(
                value, wavelengths, self.block.channel_count(), weight=1.0, alpha=alpha
            )
        else:
            values = list(_rgb(value, wavelengths))
            if mi.has_flag(flags, mi.FilmFlags.Alpha):
                values.append(alpha)
            values.append(mi.Float(1.0))
        self.block.put(position, values, active)


def _rgb(radiance: Any, wavelengths: Any) -> Any:
    """Radiance of any variant as linear sRGB."""
    if mi.is_spectral:
        return mi.spectrum_to_srgb(radiance, wavelengths)
    return mi.Color3f(radiance.x) if mi.is_monochromatic else radiance
