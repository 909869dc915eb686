"""The table and the rule follow from the rows, whatever these say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nephrite.atlas import choice
from nephrite.plugins import auto


def row(method, thickness, albedo, error, efficiency, noise=0.001):
    three = (thickness,) * 3, (albedo,) * 3, (error,) * 3, (noise,) * 3
    return {
        "method": method, "thickness": three[0], "albedo": three[1], "channels": three[2],
        "channels_error": three[3], "error": error, "error_error": noise, "efficiency": efficiency,
    }  # fmt: skip


def rows(of_model):
    """A walk that is right, and a model whose error is a function of thickness and albedo."""
    found = []
    for thickness in (1.0, 5.0, 20.0, 50.0, 200.0):
        for albedo in (0.5, 0.95, 0.999):
            found.append(row("walk", thickness, albedo, 0.01, 1.0))
            found.append(row("fast", thickness, albedo, of_model(thickness, albedo), 4.0))
            found.append(row("brdf", thickness, albedo, 0.5, 30.0))
    return found


def cell(found, thickness, albedo):
    return next(
        one
        for one in found
        if one["thickness"][0] <= thickness < one["thickness"][1]
        and one["albedo"][0] <= albedo < one["albedo"][1]
    )


def test_the_table_names_the_fastest_within_the_limit():
    found = choice.advice(rows(lambda thickness, albedo: 0.5 / thickness))
    thin, thick = cell(found, 1.0, 0.5), cell(found, 50.0, 0.5)
    assert thin["final"][0] == thin["preview"][0] == "walk"
    assert cell(found, 5.0, 0.5)["preview"][0] == "fast"
    assert thick["final"] == ("fast", pytest.approx(0.01), pytest.approx(0.001 / 3**0.5), 4.0)
    assert thick["diffusion"][0] == "fast"
    assert thin["exact"][0] == "walk"
    assert thick["count"] == 3


def test_the_rule_is_the_widest_region_that_is_right():
    found = choice.rule(rows(lambda thickness, albedo: 1.0 / thickness if albedo > 0.9 else 0.3))
    assert found is not None
    assert (found["model"], found["thickness"], found["albedo"]) == ("fast", 20.0, 0.95)
    assert found["views"] == 6
    assert found["worst"] == 0.05


def test_the_rule_begins_at_its_own_pictures():
    """Not at the thickness of another picture, which is too dark for it."""
    found = rows(lambda thickness, albedo: 0.01 if thickness > 30.0 and albedo > 0.9 else 0.3)
    rule = choice.rule([*found, row("fast", 30.0, 0.5, 0.3, 4.0)])
    assert rule is not None
    assert (rule["thickness"], rule["albedo"], rule["views"]) == (50.0, 0.95, 4)


def test_no_rule_if_nothing_else_is_right_or_nothing_is_saved():
    assert choice.rule(rows(lambda thickness, albedo: 0.3)) is None
    slow = [dict(one, efficiency=0.5) if one["method"] == "fast" else one for one in rows(lambda t, a: 0.0)]
    assert choice.rule(slow) is None


def test_noise_is_not_held_against_a_model_and_noisy_channels_say_nothing():
    noisy = [dict(one, error_error=0.2) if one["method"] == "fast" else one for one in rows(lambda t, a: 0.3)]
    assert choice.rule(noisy) is not None
    blind = [dict(one, channels_error=(0.3,) * 3) for one in rows(lambda t, a: 0.0)]
    assert choice.advice(blind) == []


def test_auto_follows_the_published_atlas():
    """Its thresholds are the rule's, rounded up to where nothing was measured between."""
    published = Path(__file__).parents[2] / "docs" / "figures" / "atlas" / "atlas.json"
    found = json.loads(published.read_text(encoding="utf-8"))["rules"]
    (final,) = [one for one in found if one["limit"] == choice.FINAL]
    assert final["model"] == auto.DIFFUSION
    assert final["thickness"] <= auto.DENSE < 1.02 * final["thickness"]
    assert abs(final["albedo"] - auto.LIGHT) < 0.001
