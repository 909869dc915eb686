"""Pictures by every model beside the exact walk's: how far they are, and how fast they get there.

They hold the light that has scattered inside the object, single and multiple: reflections at the surface and the floor
are the same for all, and their noise would hide the rest.
"""

from __future__ import annotations

import hashlib
import time
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from nephrite.atlas import contest
from nephrite.atlas.compared import Difference, Estimate, difference
from nephrite.atlas.plan import Plan, View
from nephrite.atlas.store import Cell, NotYetError, Store
from nephrite.atlas.views import LIGHTS, Loaded, Loader
from nephrite.bssrdf import kernel
from nephrite.image import errors
from nephrite.profiles.models import MODELS

__all__ = ["TRUTH", "Picture", "estimate", "methods", "pictures", "rendered"]

TRUTH = "exact walk"
"""Method that the others are compared with: unbiased, and noisy where lights are small."""

_TERMS = "single+multiple"
_SEED = 40
_GOAL = 0.015
"""Standard error of the object's light at which a picture needs no further samples."""
_MOST_ROUNDS = 4
_CHANNELS = 3


@dataclass(frozen=True)
class Picture(Difference):
    """A method in one view: how far it is from the truth, and how fast.

    `thickness`, `albedo`: mean chord in reduced mean free paths and reduced albedo, per channel. `rate`, `efficiency`:
    samples, and 1 / (relative variance), per second; relative to those of the walk with the lobe in the same view.
    """

    method: str
    object: str
    size: float
    material: str
    light: str
    thickness: tuple[float, ...]
    albedo: tuple[float, ...]
    rate: float
    efficiency: float


def methods(models: tuple[str, ...]) -> tuple[str, ...]:
    """Return what is rendered for these models: each that is not the same as one before, the walk, and brdf."""
    found: list[str] = []
    for name in models:
        if not any(_same(name, other) for other in found):
            found.append(name)
    return ("walk", *found, "brdf")


def pictures(
    plan: Plan, store: Store, names: tuple[str, ...]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the `Picture` of every view by each of the methods, and its `Contest`s; a variant must be set.

    As dictionaries. Views that there was no time for are left out.
    """
    loader, rows, contests = Loader(plan.resolution), [], []
    for view in plan.views:
        loaded = loader.load(view)
        try:
            cells = {name: rendered(plan, store, loaded, name) for name in (TRUTH, *names)}
        except NotYetError:
            continue
        shown, finer = _refined(plan, store, loaded, cells)
        truth, mask = shown.pop(TRUTH), cells[TRUTH]["mask"]
        walk, medium = cells["walk"], loaded.medium
        for name in names:
            row = Picture(
                **asdict(difference(shown[name], truth, mask)),
                **asdict(view),
                method=name,
                thickness=tuple(loaded.thickness.tolist()),
                albedo=tuple(float(a) for a in medium.albedo_prime),
                rate=float(cells[name]["rate"] / walk["rate"]),
                efficiency=float(cells[name]["efficiency"] / walk["efficiency"]),
            )
            rows.append(asdict(row))
        for rival in contest.RIVALS:
            if rival in shown and contest.CHAMPION in shown:
                lead = contest.lead(shown[contest.CHAMPION], shown[rival], truth, mask)
                row = contest.Contest(
                    **asdict(view), rival=rival, lead=lead[0], lead_error=lead[1], finer=finer
                )
                contests.append(asdict(row))
    return rows, contests


def _refined(
    plan: Plan, store: Store, loaded: Loaded, cells: dict[str, Cell]
) -> tuple[dict[str, Estimate], int]:
    """Return all pictures, and how many times the usual samples those of the contest have, the truth's too."""
    shown, finer = {name: estimate(cell) for name, cell in cells.items()}, 1
    asked = [name for name in (TRUTH, contest.CHAMPION, *contest.RIVALS) if name in cells]
    for times in plan.finer:
        if not contest.is_open(shown, shown[TRUTH], cells[TRUTH]["mask"]):
            break
        try:
            better = {name: estimate(rendered(plan, store, loaded, name, times)) for name in asked}
        except NotYetError:
            break
        shown, finer = {**shown, **better}, times
    return shown, finer


def estimate(cell: Cell) -> Estimate:
    """Return the picture of a cell."""
    return Estimate(cell["mean"].astype(np.float64), cell["error"].astype(np.float64))


def rendered(plan: Plan, store: Store, loaded: Loaded, name: str, times: int = 1) -> Cell:
    """Render a view by a method: `mean` and standard `error` of the picture, `mask`, `rate` and `efficiency`.

    `times`: the samples that the plan asks for. But for the truth's, a cell is known by the code of the plugins too,
    and a diffusion model's by the numbers of its profile: when they change, its pictures are made again.
    """
    import mitsuba as mi

    view, medium = loaded.view, loaded.medium
    spp = times * (plan.truth_spp if name == TRUTH else plan.spp)
    asked = {
        "view": str(view), "method": name, "spp": spp, "resolution": plan.resolution, "variant": mi.variant(),
        "seed": _SEED, "rig": LIGHTS[view.light], "terms": _TERMS,
        "medium": [medium.sigma_a, medium.sigma_s, medium.g, medium.eta], "rounds": [_GOAL, _MOST_ROUNDS],
    }  # fmt: skip
    if name != TRUTH:
        asked["code"] = _sources()
    if name in MODELS:
        asked["profile"] = _profile(name, medium.eta, medium.g)
    label = f"picture {view}, {name}" + (f", {times} x the samples" if times > 1 else "")
    return store.cell(label, asked, lambda: _render(loaded, name, spp))


def _render(loaded: Loaded, name: str, spp: int) -> Cell:
    """Render in rounds of two pictures, each with half of the samples: the two differ by the noise.

    Dark objects get more rounds, black ones one. The last picture is timed, after others have compiled and built
    tables. Seconds are the processor's where that is what computes: others that use the machine don't count.
    """
    import mitsuba as mi

    model, way = ("walk", "exact") if name == TRUTH else (name, "lobe")
    integrator: Any = mi.load_dict({"type": "translucent_path", "model": model, "exit": way, "terms": _TERMS})
    now = time.perf_counter if (mi.variant() or "").startswith("cuda") else time.process_time
    half = max(spp // 2, 1)
    scene, mask = loaded.scene, loaded.mask
    total, squares, count = np.zeros((*mask.shape, _CHANNELS)), np.zeros((*mask.shape, _CHANNELS)), 0
    relative, seconds, efficiency = 1.0, 1.0, 0.0
    while relative > _GOAL and count < _MOST_ROUNDS:
        pair = []
        for i in range(2):
            seed: Any = _SEED + 2 * count + i
            start = now()
            image = np.array(mi.render(scene, integrator=integrator, spp=half, seed=seed), np.float64)
            pair.append(image[..., :_CHANNELS])
            seconds = max(now() - start, 1e-6)
        total += pair[0] + pair[1]
        squares += (pair[0] - pair[1]) ** 2
        count += 1
        lit = float(total[mask].sum())
        if lit == 0.0:
            break
        relative = float(np.sqrt(squares[mask].sum())) / lit
        efficiency += (errors.efficiency(pair[0], pair[1], seconds, mask) - efficiency) / count
    return {
        "mean": (total / (2 * count)).astype(np.float32),
        "error": (np.sqrt(squares) / (2 * count)).astype(np.float16),
        "mask": mask,
        "rate": np.asarray(mask.size * half / seconds),
        "efficiency": np.asarray(efficiency),
    }


def _profile(name: str, eta: float, g: float) -> str:
    table = kernel.tabulated(name, eta, g).log_kernel.astype(np.float32)
    return hashlib.sha256(table.tobytes()).hexdigest()


@lru_cache(maxsize=1)
def _sources() -> str:
    """Return a digest of the code that renders."""
    package = Path(kernel.__file__).parents[1]
    files = sorted(path for part in ("bssrdf", "plugins") for path in (package / part).glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def _same(one: str, other: str) -> bool:
    """Whether two models are the same in a picture: the multipole, which a surface knows no thickness for."""
    tables = (kernel.tabulated(name, 1.3, 0.0).log_kernel for name in (one, other))
    return bool(np.allclose(*tables, atol=0.02))


def views_of(rows: list[dict[str, Any]]) -> list[View]:
    """Return the views of rows of `pictures`, each once."""
    return list(dict.fromkeys(View(r["object"], r["size"], r["material"], r["light"]) for r in rows))
