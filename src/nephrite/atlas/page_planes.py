"""The page's sections about half-spaces and slabs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import fmean
from typing import Any

from nephrite.atlas.plan import OWN_INCIDENCE, Plan
from nephrite.atlas.tables import paragraph, percent, points, table, title

__all__ = ["half_spaces", "slabs"]

_CLEAR = 1.5  # times the noise from which an L1 distance is more than noise

Row = dict[str, Any]


def half_spaces(rows: list[Row], plan: Plan) -> str:
    """Return the section about totals and profiles of half-spaces."""
    names = list(dict.fromkeys(row["model"] for row in rows))
    noise = max(row["noise"] for row in rows)
    own = [row for row in rows if row["incidence"] == _own(row["model"])]
    even = [row for row in rows if row["incidence"] == "diffuse"]
    summary = []
    for name in names:
        cells = [title(name), _own(name)]
        for chosen in (own, even):
            mine = [row for row in chosen if row["model"] == name]
            for quantity in ("total", "profile"):
                cells += [_mean(mine, quantity), _worst(mine, quantity)]
        summary.append(cells)
    head = (
        "model", "meant for", "total: mean", "largest", "profile: mean", "largest", "diffuse, total: mean",
        "largest", "profile: mean", "largest",
    )  # fmt: skip
    albedos = _grid("albedo′", plan.albedos)
    etas, gs = _grid("η", plan.etas), _grid("g", plan.gs)
    middle = plan.etas[len(plan.etas) // 2]
    plain = [row for row in own if row["eta"] == middle and row["g"] == plan.gs[0]]
    first_g = [row for row in own if row["g"] == plan.gs[0]]
    at_eta = [row for row in own if row["eta"] == middle]
    parts = [
        "## Half-spaces",
        paragraph(
            f"Errors in percent of the scattered light that leaves, over albedo′ {_list(plan.albedos)},",
            f"η {_list(plan.etas)}, g {_list(plan.gs)}. *Total*: of all that leaves, against the exact solution",
            "(`nephrite.physics.halfspace`). *Profile*: L1 distance of 2 π r R(r) from a simulated searchlight",
            f"(`nephrite.physics.searchlight`); its noise alone gives {percent(noise)} % at the most. Models are",
            'compared under the light that they are meant for, and under even light from everywhere ("diffuse"), which',
            "is what a render asks of them. To models of multiple scattering the exact single scattering is added.",
        ),
        table(head, summary),
        f"Total, at η = {middle:g}, g = {plan.gs[0]:g}, signed, under each model's own light:",
        _table(names, plain, "total", "albedo", albedos, signed=True),
        "Profile, likewise:",
        _table(names, plain, "profile", "albedo", albedos),
    ]
    for axis, grid, chosen, where in (
        ("eta", etas, first_g, f"g = {plan.gs[0]:g}"),
        ("g", gs, at_eta, f"η = {middle:g}"),
    ):
        if len(grid) > 1:
            parts += [
                f"Mean size of the total's error over albedo′, at {where}:",
                _table(names, chosen, "total", axis, grid),
                "Profile, likewise:",
                _table(names, chosen, "profile", axis, grid),
            ]
    return "\n\n".join(parts)


def slabs(rows: list[Row], plan: Plan) -> str:
    """Return the section about slabs."""
    names = list(dict.fromkeys(row["model"] for row in rows))
    eta = plan.slab_etas[-1]
    own = [row for row in rows if row["incidence"] == _own(row["model"]) and row["eta"] == eta]
    summary = []
    for name in names:
        mine = [row for row in own if row["model"] == name]
        summary.append([title(name), _own(name), *_by_thickness(mine, "reflected", plan)])
        if not any(math.isnan(row["transmitted"]) for row in mine):
            summary.append(
                [f"{title(name)}, transmitted", _own(name), *_by_thickness(mine, "transmitted", plan)]
            )
    noise = max(max(row["reflected_error"], row["transmitted_error"]) for row in rows)
    known = [row for row in own if not math.isnan(row["transmitted"]) and row["albedo"] >= 0.9]
    detail = [
        [
            f"{row['albedo']:g}", f"{row['thickness']:g}", points(row["true_reflected"]), points(row["reflected"]),
            points(row["true_transmitted"]), points(row["transmitted"]),
        ]
        for row in sorted(known, key=lambda row: (row["albedo"], row["thickness"]))
    ]  # fmt: skip
    parts = [
        "## Slabs",
        paragraph(
            f"Isotropic slabs of η = {eta:g}, thickness in mean free paths; light that scatters inside and leaves, in",
            f"percent of the light that enters; the truth's standard error is below {percent(noise)}. Errors are in",
            f"the same percent, mean sizes over albedo {_list(plan.slab_albedos)}. Only the multipole knows of a far",
            "side; the others are what a half-space reflects.",
        ),
        table(["reflected", "meant for", *(f"{t:g}" for t in plan.thicknesses)], summary),
    ]
    if detail:
        head = ("albedo", "thickness", "reflected", "multipole", "transmitted", "multipole")
        parts += ["Truth and multipole:", table(head, detail)]
    return "\n\n".join(parts)


def _own(name: str) -> str:
    return OWN_INCIDENCE.get(name, "normal")


def _mean(rows: list[Row], quantity: str) -> str:
    return _told(fmean(abs(row[quantity]) for row in rows), _noise(rows, quantity))


def _worst(rows: list[Row], quantity: str) -> str:
    clear = [row for row in rows if abs(row[quantity]) > _CLEAR * _noise([row], quantity)]
    if not clear:
        return _told(0.0, max(_noise([row], quantity) for row in rows))
    return percent(max((row[quantity] for row in clear), key=abs), signed=quantity == "total")


def _noise(rows: list[Row], quantity: str) -> float:
    """What the error of a perfect model would be: totals have no noise."""
    return fmean(row["noise"] for row in rows) if quantity == "profile" else 0.0


def _told(value: float, noise: float, signed: bool = False) -> str:
    return f"< {percent(2.0 * noise)}" if abs(value) < _CLEAR * noise else percent(value, signed=signed)


def _grid(name: str, values: Sequence[float]) -> list[tuple[str, float]]:
    return [(f"{name} {value:g}", value) for value in values]


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _table(
    names: list[str], rows: list[Row], quantity: str, axis: str, grid: list[tuple[str, float]], signed: bool = False
) -> str:  # fmt: skip
    size: Callable[[float], float] = (lambda x: x) if signed else abs
    lines = []
    for name in names:
        cells = []
        for _, value in grid:
            mine = [row for row in rows if row["model"] == name and row[axis] == value]
            mean = fmean(size(row[quantity]) for row in mine)
            cells.append(_told(mean, _noise(mine, quantity), signed))
        lines.append([title(name), *cells])
    return table(["%", *(label for label, _ in grid)], lines)


def _by_thickness(rows: list[Row], side: str, plan: Plan) -> list[str]:
    cells = []
    for thickness in plan.thicknesses:
        here = [row for row in rows if row["thickness"] == thickness]
        cells.append(points(fmean(abs(row[side] - row[f"true_{side}"]) for row in here)))
    return cells
