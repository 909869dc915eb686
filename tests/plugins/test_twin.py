"""The twin of a path: its mean is what it is said to be, and it takes the noise of luck out of looking transport up."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.physics import fresnel, phase
from nephrite.physics.single import deep_share, single_scattering_share
from nephrite.plugins import channels, twin
from support import scenes

_SURE = 5.0  # standard errors: 27 numbers, a false alarm in 60,000 runs


@pytest.mark.parametrize("g", [0.0, 0.8, -0.4])
@pytest.mark.parametrize(("eta", "cosine"), [(1.0, 0.6), (1.33, 1.0), (1.5, 0.15)])
def test_its_mean_is_known(g, eta, cosine):
    """Steep and level light, whichever channel leads; one of them absorbs much."""
    count = 1 << 20
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, count)
    sigma_s, sigma_t = mi.Spectrum(2.0, 0.5, 1.0), mi.Spectrum(2.1, 0.5, 3.0)
    inside = float(fresnel.refracted_cosine(np.array([cosine]), eta)[0])
    down = mi.Vector3f((1 - inside**2) ** 0.5, 0.0, -inside)
    channel, β, ratio = channels.lead(mi.Spectrum(1.0, 0.7, 0.4), sigma_t, sampler.next_1d())
    free = -dr.log(1 - sampler.next_1d()) / channels.pick(sigma_t, channel)
    turned = mi.Frame3f(down).to_world(
        mi.Vector3f(*phase.sample(sampler.next_1d(), sampler.next_1d(), mi.Float(g)))
    )
    values = np.array(
        twin.second(
            β, ratio, channel, sigma_t, sigma_s, mi.Float(eta), mi.Normal3f(0, 0, 1), down, free, turned
        )
    )
    kept = deep_share(np.array([cosine]), g, eta)[0] * (1 - single_scattering_share(g, eta))
    known = np.array([1.0, 0.7, 0.4]) * np.array(twin.expected(sigma_t, sigma_s, mi.Float(kept)))[:, 0]
    error = values.std(axis=1) / count**0.5
    print(values.mean(axis=1), known, error)
    assert (np.abs(values.mean(axis=1) - known) < _SURE * error + 2e-4 * known).all()


@pytest.mark.slow
def test_where_it_is_flat_and_thick_no_luck_is_left():
    """But that of what the surface reflects: variance over squared mean is .023; without twins it is .072."""
    scene = scenes.camera(8, fov=4.0) | {"sky": scenes.environment(1.0)}
    scene["ball"] = {"type": "sphere", "radius": 60.0} | scenes.translucent(0.02, 1.0)
    scene["sensor"]["to_world"] = mi.ScalarTransform4f().look_at([0, 0, 300], [0, 0, 0], [0, 1, 0])
    integrator = mi.load_dict(scenes.ours(model="transport", walks=200_000, terms="multiple"))
    loaded = mi.load_dict(scene)
    found = np.array(
        [mi.render(loaded, integrator=integrator, spp=8, seed=seed).numpy() for seed in range(64)]
    )
    relative = 8 * found.var(axis=0).mean() / np.square(found.mean())
    print(relative)
    assert relative < 0.04
