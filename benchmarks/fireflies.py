"""Whether single paths stand out of the noise: how long the tail of the pixels' errors is, for each model.

    python benchmarks/fireflies.py [--spp 256] [--models walk dipole] [--meshes plane sphere dragon-tiny]

A plane (the face of a thick block), a sphere and the dragon, of skim milk, 100 mm long, under a constant sky. A pixel's
error is the length of the vector (red, green, blue) by which two renders differ, over the root of two; pixels within
`RIM` of the silhouette are left out. `tail` is the 99.9th percentile of the errors over their median. For a Gaussian of
even width it is between the two values of `NORMAL`: channels that vary alike bring the greater, independent ones the
less. Noise is not even over a picture: `own` is the same with each error in units of the standard deviation there, that
of the eight pixels around it (its own would hide what stands out). `worst` is the largest error so; `channels` the tail
of the errors of single channels, against the greater value of `NORMAL`.
Pictures go to out/fireflies/.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats

import nephrite  # noqa: F401 (before Mitsuba)
from nephrite.image.write import save
from nephrite.scene import build, camera, meshes, named
from nephrite.scene.files import mesh_plugin
from nephrite.scene.translucent import object_mask

import mitsuba as mi  # isort: skip

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

SIZE = 100.0  # mm
PASSES = 8  # of each render: their spread tells the noise
RIM = 2  # pixels
SKY = 0.4  # radiance, dark enough to tell the object from it
NORMAL = tuple(float(stats.chi.isf(0.001, free) / stats.chi.median(free)) for free in (3, 1))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--meshes", nargs="*", default=["plane", "sphere", "dragon"])
    parser.add_argument("--models", nargs="*", default=["dipole", "tabulated", "walk", "brdf"])
    parser.add_argument("--material", default="skimmilk")
    parser.add_argument("--resolution", type=int, nargs=2, default=[160, 120])
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--out", type=Path, default=Path("out/fireflies"))
    options = parser.parse_args()
    mi.set_variant(options.variant)
    from support import measure

    options.out.mkdir(parents=True, exist_ok=True)
    print(
        f"a Gaussian's tail is {NORMAL[0]:.2f} (channels independent) to {NORMAL[1]:.2f} (alike); "
        "noise: median error, percent of the object's mean"
    )
    for name in options.meshes:
        scene = mi.load_dict(_scene(name, options.material, tuple(options.resolution)))
        inside = ndimage.binary_erosion(object_mask(scene), iterations=RIM)
        for model in options.models:
            start = time.perf_counter()
            integrator = build.integrator_dict(model=model)
            own = measure.passes(scene, integrator, options.spp // PASSES, 2 * PASSES, seed=1)
            errors, spread = _errors(own.pictures)
            channels = errors[inside]
            errors = np.linalg.norm(channels, axis=-1)
            scores = errors / spread[inside]
            noise = 100 * np.median(errors) / np.linalg.norm(own.mean[inside].mean(0))
            print(
                f"{name:12s} {model:10s} {inside.sum()} pixels, noise {noise:5.2f} %: tail {_tail(errors):5.2f}, "
                f"own {_tail(scores):5.2f}, worst {scores.max():4.1f}, "
                f"channels {_tail(channels):5.2f} | {time.perf_counter() - start:.0f} s",
                flush=True,
            )
            save(options.out / f"{name}-{model}.png", own.mean)


def _scene(name: str, material: str, resolution: tuple[int, int]) -> dict[str, Any]:
    """Return the scene of a named mesh, or of a `plane` that fills the picture."""
    mesh = meshes.placed(named.find("cube" if name == "plane" else name), SIZE)
    sensor = camera.framing(mesh.vertices, resolution)
    if name == "plane":
        sensor = camera.sensor(
            (0.1 * SIZE, 0.6 * SIZE, 1.3 * SIZE), (0.0, 0.5 * SIZE, 0.5 * SIZE), resolution
        )
    return {
        "type": "scene",
        "sensor": sensor,
        "sky": {"type": "constant", "radiance": SKY},
        "object": {**mesh_plugin(mesh), "bsdf": build.bsdf_dict(material)},
    }


def _errors(pictures: NDArray) -> tuple[NDArray, NDArray]:
    """Return the error of one half of the passes, (height, width, 3), and its length's standard deviation."""
    one, other = pictures[:PASSES], pictures[PASSES:]
    variance = (one.var(0, ddof=1) + other.var(0, ddof=1)).sum(-1) / (2 * PASSES)
    ring = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]]) / 8
    around = ndimage.convolve(variance, ring, mode="nearest")
    errors = np.abs(one.mean(0) - other.mean(0)) / np.sqrt(2)
    return errors, np.sqrt(np.maximum(around, 1e-30))


def _tail(errors: NDArray) -> float:
    return float(np.quantile(errors, 0.999) / np.median(errors))


if __name__ == "__main__":
    main()
