"""The integrator plugin `translucent_path`: a path tracer that walks through translucent objects."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.errors import VariantError
from nephrite.plugins import auto, camera, collector, path, settings
from nephrite.plugins.balance import balance, fingerprint
from nephrite.plugins.kept import Kept
from nephrite.plugins.media import Media


class TranslucentPath(mi.SamplingIntegrator):
    r"""
    Path tracer for translucent objects (:monosp:`translucent_path`)
    ----------------------------------------------------------------

    .. pluginparameters::

     * - model
       - |string|
       - What happens under a translucent surface: ``walk`` (volumetric random walk), ``transport`` (the same,
         precomputed from the second scattering event on), ``dipole`` (diffusion from there on), ``brdf`` (light
         leaves where it entered), or ``auto`` (chosen for each object by its optical thickness and albedo; the choice
         is logged). (Default: walk)
     * - profile
       - |string|
       - For ``measured``: a CSV file of r in mm and R in 1/mm^2, one column or three for red, green and blue.
     * - thickness
       - |float|
       - For ``multipole``: thickness of the plate or sheet in mm; see the BSDF's ``unit``. (Default: without end)
     * - walks
       - |int|
       - For ``transport``: walks per object that it is precomputed from. (Default: by the number of samples, from
         0.8 to 4 million)
     * - terms
       - |string|
       - ``all``, or a sum of ``reduced``, ``single`` and ``multiple``: the paths that scatter in media never,
         once, or more often; everything that is no medium counts as ``reduced``. (Default: all)
     * - exit
       - |string|
       - ``exact``: light leaves in the direction that it has, and finds lights by chance; unbiased. ``lobe``: lights
         are connected to, by an estimate of the exitant radiance from the walks' last directions. (Default: lobe)
     * - max_depth
       - |int|
       - Longest path, as in Mitsuba's integrators; a whole walk counts as one bounce. -1: no limit. (Default: -1)
     * - rr_depth
       - |int|
       - Depth at which Russian roulette begins. (Default: 5)
     * - max_steps
       - |int|
       - Longest walk. What it cuts is measured and logged. (Default: 1000000)
     * - hide_emitters
       - |bool|
       - Hide directly visible emitters. (Default: no)

    A drop-in for :monosp:`volpath`: it renders the :monosp:`translucent` BSDF, any shape with a :monosp:`homogeneous`
    interior medium (isotropic or Henyey-Greenstein) behind a :monosp:`dielectric` or :monosp:`roughdielectric`, and
    everything else that a path tracer does. ``model: walk, exit: exact`` has the expectation of :monosp:`volpathmis`.

    Differences to :monosp:`volpath`: which side of a surface a ray is on follows from the path, not from the winding;
    the walk's roulette begins where half of its light is gone; media that are not homogeneous, or that fill the space
    around objects, are refused. The sampler of the sensor gives the sample count; numbers are independent.
    Derivatives are not supported.

    .. code-block:: python

        'type': 'translucent_path', 'model': 'walk', 'exit': 'lobe', 'terms': 'all'
    """

    def __init__(self, props: Any) -> None:
        """Read the parameters (see the class)."""
        self.settings = settings.read(props)
        super().__init__(props)
        if mi.is_polarized:
            raise VariantError(f"translucent_path does not track polarisation, as {mi.variant()} does.")
        self.choices: list[auto.Choice] = []
        self.cut_fraction = 0.0
        self._balance: tuple[Any, Any] | None = None
        self._kept = Kept()

    @collector.kept_off()
    def sample(
        self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
    ) -> tuple[Any, Any, list[Any]]:
        """Return radiance and validity along rays, and no AOVs: Mitsuba's contract for nested integrators."""
        media = self._survey(scene)
        result = path.trace(self.settings, scene, media, sampler, camera.OneRay(ray, active))
        return result.L, result.valid, []

    @collector.kept_off()
    def render(
        self, scene: Any, sensor: Any = 0, seed: int = 0, spp: int = 0, develop: bool = True, evaluate: bool = True
    ) -> Any:  # fmt: skip
        """Render an image; each lane traces many paths, one after the other, so that none waits for the longest."""
        sensor = scene.sensors()[sensor] if isinstance(sensor, int) else sensor
        samples = int(np.prod(sensor.film().crop_size())) * (spp or sensor.sampler().sample_count())
        seed = int(mi.UInt32(seed)[0])
        media = self._survey(scene, sensor, samples, seed)
        with dr.suspend_grad():
            source = camera.Camera(sensor, spp, seed)
            result = path.trace(self.settings, scene, media, source.sampler, source)
            # all that the loop leaves behind at once: whatever is asked for later would run it again
            dr.eval(source.block.tensor(), result.cut, result.started)
            film = sensor.film()
            film.put_block(source.block)
            self._report(result)
            if not develop:
                return None
            image = film.develop()
            if evaluate:
                dr.eval(image)
        return image

    def _survey(self, scene: Any, sensor: Any = None, samples: int = 0, seed: int = 0) -> Media:
        media = Media.of(scene)
        s = self.settings
        self.choices = auto.choose(s.model, media, scene, profiles=s.profiles, thickness=s.thickness)
        if media.any_jump:
            # the passes of one picture ask for the same again and again
            key = fingerprint(media)
            if self._balance is None or self._balance[0] != key:
                balance(media, scene)
                self._balance = (key, media.balance)
            media.balance = self._balance[1]
        with dr.suspend_grad():
            self.choices = self._kept.prepare(s, scene, media, self.choices, sensor, samples, seed)
        return media

    def _report(self, result: path.Result) -> None:
        if not self.settings.max_steps < settings.NO_LIMIT:
            return
        lost, total = dr.sum(result.cut), dr.sum(result.started)
        self.cut_fraction = float(lost[0] / total[0]) if total[0] > 0 else 0.0
        if self.cut_fraction > 1e-4:
            log: Any = mi.Log
            log(
                mi.LogLevel.Warn,
                f"max_steps = {self.settings.max_steps} cut {100 * self.cut_fraction:.2g} % of the walks' light",
            )

    def to_string(self) -> str:
        """Describe the integrator in one line."""
        s = self.settings
        return f"TranslucentPath[model = {s.model}, exit = {s.exit}, terms = {s.terms}]"


def register() -> None:
    """Register the plugin in the present variant."""
    mi.register_integrator("translucent_path", TranslucentPath)
