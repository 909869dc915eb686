"""Half-spaces and slabs: published errors come out, and exact models have none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nephrite.atlas import planes
from nephrite.atlas.plan import QUICK
from nephrite.atlas.store import Store

FEW = replace(
    QUICK, albedos=(0.5, 0.8, 0.95, 0.99, 0.999), etas=(1.0,), photons=2**14, slab_photons=2**14,
    thicknesses=(1.0, 50.0),
)  # fmt: skip


@pytest.fixture(scope="module")
def totals():
    rows = planes.half_spaces(FEW, Store(None), ("dipole", "better_dipole", "photon_beam", "normalized"))
    return lambda model, incidence: [
        100 * row["total"] for row in rows if row["model"] == model and row["incidence"] == incidence
    ]


@pytest.mark.parametrize(
    ("model", "published"),
    [
        ("dipole", [-24, -12, -4, -1, 0]),
        ("better_dipole", [7, 13, 18, 18, 17]),
        ("photon_beam", [11, 14, 14, 12, 10]),
    ],
)
def test_totals_of_an_index_matched_half_space(totals, model, published):
    """Against exact H functions, normal incidence; for the better dipole with exact single scattering."""
    assert totals(model, "normal") == pytest.approx(published, abs=0.8)


def test_a_model_with_the_exact_total_has_no_error(totals):
    assert totals("normalized", "diffuse") == pytest.approx([0.0] * 5, abs=0.02)


def test_a_thick_slab_is_a_half_space_and_a_multipole_a_dipole():
    rows = planes.slabs(FEW, Store(None), ("dipole", "multipole"))
    for row in rows:
        assert np.isnan(row["transmitted"]) == (row["model"] == "dipole")
        assert 0.0 <= row["true_reflected"] + row["true_transmitted"] <= 1.0
    thick = [row for row in rows if row["thickness"] == 50.0 and row["albedo"] == 0.5]
    assert len({round(row["reflected"], 5) for row in thick}) == 1
    assert all(row["true_transmitted"] < 1e-6 for row in thick)


def test_one_simulation_serves_all_models():
    store = Store(None)
    planes.half_spaces(FEW, store, ("dipole",))
    made = store.made
    planes.half_spaces(FEW, store, ("dipole", "normalized"))
    assert store.made == made == 2
