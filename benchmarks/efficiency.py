"""Efficiency and samples a second on benchmark scene B1, the skim-milk dragon: every model beside Mitsuba's volpathmis.

    .venv/bin/python benchmarks/efficiency.py [--spp 16] [--repeat 2]

Efficiency = mean^2 / (variance * seconds) over the pixels of the dragon's body; variance from two renders with other
seeds, seconds of the whole render call after a warm-up, in which `transport` makes its walks: they
are not counted, nor is the noise that they leave in both renders. Ratios only mean something between rows of one run.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import mitsuba as mi
import numpy as np

import nephrite
from nephrite import materials
from nephrite.scene import build, named

RESOLUTION = (400, 300)
BODY = (slice(130, 240), slice(80, 180))  # rows and columns of the 400 x 300 picture
METHODS: dict[str, dict[str, Any]] = {
    "volpathmis": {"type": "volpathmis", "max_depth": -1, "rr_depth": 1000},
    "walk, exact exit": {"type": "translucent_path", "model": "walk", "exit": "exact"},
    "walk, lobe exit": {"type": "translucent_path", "model": "walk", "exit": "lobe"},
    "transport": {"type": "translucent_path", "model": "transport"},
    "dipole": {"type": "translucent_path", "model": "dipole"},
    "tabulated": {"type": "translucent_path", "model": "tabulated"},
    "brdf": {"type": "translucent_path", "model": "brdf"},
}


def scene() -> Any:
    """Return B1 with Mitsuba's own dielectric and homogeneous medium, which all methods render."""
    medium = materials.find("skim milk").medium
    largest = max(medium.sigma_t)
    interior = {
        "type": "homogeneous",
        "scale": largest,
        "sigma_t": {"type": "rgb", "value": [value / largest for value in medium.sigma_t]},
        "albedo": {"type": "rgb", "value": list(medium.albedo)},
        "phase": {"type": "isotropic"},
    }
    surface = {"type": "dielectric", "int_ior": medium.eta, "ext_ior": 1.0}
    described = build.scene_dict(
        named.find("dragon"), surface, 100.0, light="benchmark", resolution=RESOLUTION
    )
    described["object"]["interior"] = interior
    return mi.load_dict(described, optimize=False)


def measure(b1: Any, method: dict[str, Any], spp: int, repeat: int) -> dict[str, float]:
    """Render two pictures `repeat` times; return efficiency, samples a second and the mean, the best of the runs."""
    integrator: Any = mi.load_dict(method)
    mi.render(b1, integrator=integrator, spp=1, seed=0).numpy()
    best: dict[str, float] = {}
    for run in range(repeat):
        pictures, seconds = [], []
        for seed in (1 + 2 * run, 2 + 2 * run):
            start = time.perf_counter()
            pictures.append(mi.render(b1, integrator=integrator, spp=spp, seed=seed).numpy()[..., :3])
            seconds.append(time.perf_counter() - start)
        a, b = pictures
        mean = float((a + b)[BODY].mean()) / 2
        variance = float(((a - b)[BODY] ** 2).mean()) / 2
        each = sum(seconds) / 2
        row = {
            "mean": mean,
            "efficiency": mean * mean / (variance * each),
            "rate": a.shape[0] * a.shape[1] * spp / each / 1e6,
        }
        best = {key: max(row[key], best.get(key, 0.0)) for key in row}
    return best


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--repeat", type=int, default=2)
    given = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    b1 = scene()
    rows = {name: measure(b1, method, given.spp, given.repeat) for name, method in METHODS.items()}
    first, walk = rows["volpathmis"], rows["walk, lobe exit"]
    print(
        f"Nephrite {nephrite.__version__}, {mi.variant()}, scene B1, {given.spp} spp, best of {given.repeat}"
    )
    print(
        "| method | mean | efficiency | / volpathmis | Msamples/s | / walk |\n| --- | --- | --- | --- | --- | --- |"
    )
    for name, row in rows.items():
        print(
            f"| {name} | {row['mean']:.4f} | {row['efficiency']:.4f} | {row['efficiency'] / first['efficiency']:.1f} | "
            f"{row['rate']:.3f} | {row['rate'] / walk['rate']:.2f} |"
        )


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
