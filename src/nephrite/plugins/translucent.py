"""The BSDF plugin `translucent`: a medium behind a dielectric surface, and its local approximation."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.physics import inversion
from nephrite.physics.color import color_map
from nephrite.plugins import parameters


class Translucent(mi.BSDF):
    r"""
    Translucent material (:monosp:`translucent`)
    --------------------------------------------

    .. pluginparameters::

     * - material
       - |string|
       - Name of a material of the library, such as ``jade`` or ``skim milk``.
     * - sigma_a, sigma_s
       - |spectrum| or |texture|
       - Instead: absorption and scattering coefficients in 1/mm. Unbounded.
     * - albedo, radius
       - |spectrum| or |texture|
       - Instead: colour that a thick piece shows under its surface (1: no absorption), and reduced mean free path in
         mm, per channel.
     * - g
       - |float|
       - Mean cosine of the Henyey-Greenstein phase function, in (-1, 1). (Default: the material's, or 0) A named
         material keeps its reduced scattering, which is what was measured.
     * - int_ior, ext_ior
       - |float| or |string|
       - Indices of refraction. (Default: the material's, or 1.3; and 1)
     * - alpha
       - |float|
       - Roughness of the surface (GGX); 0 is smooth. (Default: 0)
     * - unit
       - |float|
       - Length of one scene unit in millimetres. (Default: 1)
     * - emission
       - |spectrum|
       - Radiance that the medium emits per mm: the Q of the radiative transfer equation. (Default: none)

    Under any of Mitsuba's own integrators this is the *local* approximation of subsurface scattering: light leaves
    where it entered, as much of it as a thick flat piece sends out, under the dielectric surface. Under
    :monosp:`translucent_path` the same material is rendered as the volume that it is.

    Textures of coefficients are read where light enters, and hold for the whole walk from there.

    .. code-block:: python

        'type': 'translucent', 'material': 'jade', 'unit': 1.0
    """

    def __init__(self, props: Any) -> None:
        """Read the parameters (see the class)."""
        super().__init__(props)
        p = parameters.read(props)
        self.name, self.g, self.eta, self.alpha, self.unit = p.name, p.g, p.eta, p.alpha, p.unit
        self.first, self.second, self.by_color, self.emission = p.first, p.second, p.by_color, p.emission
        self.lobe = lobe.exit_lobe(self.eta)
        self.colors = color_map(self.eta, self.g, self.alpha)
        self.interface = None
        if self.alpha > 0 and self.eta != 1:
            self.interface = mi.load_dict(
                {"type": "roughdielectric", "distribution": "ggx", "alpha": max(self.alpha, 1e-3),
                 "int_ior": self.eta, "ext_ior": 1.0}
            )  # fmt: skip
        specular = (
            mi.BSDFFlags.GlossyReflection if self.interface is not None else mi.BSDFFlags.DeltaReflection
        )
        side = mi.BSDFFlags.FrontSide
        self.m_components = [specular | side, mi.BSDFFlags.DiffuseReflection | side]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def coefficients(self, si: Any, active: Any) -> tuple[Any, Any]:
        """Return sigma_a and sigma_s in 1/(scene unit) at a surface interaction."""
        first = dr.maximum(self.first.eval(si, active), 0.0)
        second = dr.maximum(self.second.eval(si, active), 0.0)
        if self.by_color:
            extinction = 1.0 / dr.maximum(second, inversion.MIN_RADIUS)
            falloff = self.colors.falloff(dr.minimum(first, 1.0))
            absorbed = extinction * dr.minimum(falloff * falloff * (1.0 / 3.0), 1.0)
            first, second = absorbed, (extinction - absorbed) / (1.0 - self.g)
        return first * self.unit, second * self.unit

    @property
    def varies(self) -> bool:
        """Whether the coefficients differ from point to point."""
        return self.first.varies or self.second.varies

    def emitted(self, si: Any, active: Any) -> Any:
        """Return the volumetric emission per scene unit at a surface interaction."""
        return self.emission.eval(si, active) * self.unit if self.emission is not None else mi.Spectrum(0.0)

    def diffuse_reflectance(self, si: Any, active: Any) -> Any:
        """Return the share of the light that has entered which leaves a thick flat piece again, in [0, 1]."""
        return self.colors.of_coefficients(*self.coefficients(si, active))

    def _glossy(self, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return value and density of the rough surface's reflection; nothing for a smooth one."""
        if self.interface is None:
            return mi.Spectrum(0.0), mi.Float(0.0)
        return self.interface.eval_pdf(self._only_reflection(mi.TransportMode.Radiance), si, wo, active)

    @staticmethod
    def _only_reflection(mode: Any) -> Any:
        """Context in which the interface reflects for certain: its density is without the Fresnel term."""
        return mi.BSDFContext(mode, 0xFFFFFFFF, 0)

    def _reflected(self, cos_theta: Any) -> Any:
        exact: Any = mi.fresnel
        return exact(cos_theta, self.eta)[0]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        """Value times cosine, and density of `sample`, per solid angle."""
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active = active & (cos_i > 0) & (cos_o > 0)
        reflected = self._reflected(cos_i)
        value, pdf = mi.Spectrum(0.0), mi.Float(0.0)
        both = ctx.is_enabled(mi.BSDFFlags.DiffuseReflection, 1) and ctx.is_enabled(self._specular, 0)
        if ctx.is_enabled(mi.BSDFFlags.DiffuseReflection, 1):
            exit_pdf = lobe.pdf(cos_o, self._reflected(cos_o), self.lobe.normalization)
            value += (1.0 - reflected) * self.diffuse_reflectance(si, active) * exit_pdf
            pdf += (1.0 - reflected if both else 1.0) * mi.warp.square_to_cosine_hemisphere_pdf(wo)
        if ctx.is_enabled(self._specular, 0) and self.interface is not None:
            glossy, glossy_pdf = self._glossy(si, wo, active)
            value += glossy
            pdf += (reflected if both else 1.0) * glossy_pdf
        return value & active, dr.select(active, pdf, 0.0)

    @property
    def _specular(self) -> Any:
        return mi.BSDFFlags.GlossyReflection if self.interface is not None else mi.BSDFFlags.DeltaReflection

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Value times cosine, per solid angle."""
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Density of `sample` per solid angle."""
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        """Choose the surface's reflection by the Fresnel term, or else the diffuse lobe."""
        diffuse_on = ctx.is_enabled(mi.BSDFFlags.DiffuseReflection, 1)
        specular_on = ctx.is_enabled(self._specular, 0)
        cos_i = mi.Frame3f.cos_theta(si.wi)
        active = active & (cos_i > 0)
        reflected = self._reflected(cos_i)
        share = reflected if diffuse_on and specular_on else mi.Float(1.0 if specular_on else 0.0)
        mirror = active & (sample1 < share)
        bs: Any = dr.zeros(mi.BSDFSample3f)
        bs.eta = 1.0
        bs.wo = mi.warp.square_to_cosine_hemisphere(sample2)
        if self.interface is not None:
            reused = sample1 / dr.maximum(share, 1e-6)
            glossy = self.interface.sample(self._only_reflection(ctx.mode), si, reused, sample2, mirror)[0]
            bs.wo = dr.select(mirror, glossy.wo, bs.wo)
        else:
            bs.wo = dr.select(mirror, mi.reflect(si.wi), bs.wo)
        bs.sampled_component = dr.select(mirror, mi.UInt32(0), mi.UInt32(1))
        bs.sampled_type = dr.select(
            mirror, mi.UInt32(+self._specular), mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        )
        value, pdf = self.eval_pdf(ctx, si, bs.wo, active)
        delta = mirror & (self.interface is None)
        bs.pdf = dr.select(delta, share, pdf)
        active &= (bs.pdf > 0) & (mi.Frame3f.cos_theta(bs.wo) > 0)
        weight = dr.select(delta, reflected / dr.maximum(share, 1e-20), value / dr.maximum(bs.pdf, 1e-20))
        return bs, weight & active

    def traverse(self, callback: Any) -> None:
        """Expose the textures."""
        names = ("albedo", "radius") if self.by_color else ("sigma_a", "sigma_s")
        callback.put(names[0], self.first.texture, mi.ParamFlags.Differentiable)
        callback.put(names[1], self.second.texture, mi.ParamFlags.Differentiable)
        if self.emission is not None:
            callback.put("emission", self.emission.texture, mi.ParamFlags.Differentiable)

    def parameters_changed(self, keys: Any) -> None:
        """Nothing is cached."""

    def to_string(self) -> str:
        """Describe the material in one line."""
        return (
            f"Translucent[name = {self.name!r}, g = {self.g:g}, eta = {self.eta:g}, alpha = {self.alpha:g}, "
            f"unit = {self.unit:g} mm, by_color = {self.by_color}]"
        )


def register() -> None:
    """Register the plugin in the present variant."""
    mi.register_bsdf("translucent", Translucent)
