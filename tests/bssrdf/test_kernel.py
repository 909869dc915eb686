"""Tables of radial kernels: totals, interpolation, and poles that draw them well."""

import math

import numpy as np

from nephrite.bssrdf import kernel
from nephrite.physics.fresnel import boundary_factor
from nephrite.profiles import StandardDipole

BOUNDARY = boundary_factor(1.3)


def _dipole(albedo, r):
    return StandardDipole(1 - albedo, albedo, BOUNDARY).eval(r)


TABLE = kernel.tabulate(_dipole)
ALBEDOS = kernel.albedos()


def test_interpolation_between_rows_and_edges_keeps_the_profile():
    """Bilinear in the logarithm, halfway between rows: the light that leaves a plane stays within .2 %."""
    row = np.arange(0, 48) + 0.5
    t = (row / (kernel.ROWS - 1)) ** 2
    r = np.exp2(np.linspace(-8, 9, 3000))
    x = np.minimum((np.log2(r) - kernel.FIRST) / kernel.STEP, kernel.EDGES - 1.001)
    edge = x.astype(int)
    between = np.array([
        0.5 * ((1 - (x - edge)) * (low[edge] + high[edge]) + (x - edge) * (low[edge + 1] + high[edge + 1]))
        for low, high in zip(TABLE.log_kernel[:48], TABLE.log_kernel[1:49], strict=True)
    ])  # fmt: skip
    exact = _dipole((1 - t**2)[:, None], r[None, :])
    for found, truth in zip(np.exp2(between), exact, strict=True):
        wrong = np.trapezoid(np.abs(found - truth) * r, r) / np.trapezoid(truth * r, r)
        assert wrong < 2e-3


def test_poles_draw_every_row_with_little_variance():
    """kernel^2 / density over the plane, against the square of the total: 1 would be without variance."""
    r = np.exp2(np.linspace(-8, 9, 4000))
    for row in range(kernel.ROWS - 4):
        z1, z2, share = TABLE.poles[row]
        density = sum(
            s * z / (2 * math.pi * (r * r + z * z) ** 1.5) for z, s in ((z1, share), (z2, 1 - share))
        )
        value = _dipole(ALBEDOS[row], r)
        second = np.trapezoid(value**2 / density * 2 * math.pi * r, r)
        total = np.trapezoid(value * 2 * math.pi * r, r)
        assert second / total**2 < 1.35


def test_a_kernel_of_nothing_is_a_table_of_nothing():
    table = kernel.tabulate(
        lambda albedo, r: np.full(np.broadcast_shapes(np.shape(albedo), np.shape(r)), np.nan)
    )
    assert np.all(table.log_kernel <= -100)
    assert np.all(np.isfinite(table.poles))
