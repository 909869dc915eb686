"""Relighting of benchmark scene B1, the skim-milk dragon at 400 x 300: what a frame costs, and its bias.

    .venv/bin/python benchmarks/relight.py [--spp 0] [--positions 36] [--transport FILE] [--pictures FOLDER]

Times are wall clock: of moving the light, and of the frame that follows. With `--spp`, frames are compared with the
walk of so many samples a pixel, under B1's own light and under one in front: see `nephrite.atlas.compared`.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from efficiency import scene
from numpy.typing import NDArray

import nephrite
from nephrite.atlas.compared import Estimate, difference
from nephrite.image import figure, write
from nephrite.relighting import Viewer, load, precompute
from nephrite.scene.translucent import object_mask

OWN, FRONT = (-0.9, 1.6, -0.9), (0.9, 1.4, 0.8)  # positions of the light, in units of the dragon's size
SIZE, HALF_SIDE, AIM = 100.0, 0.35, (0.0, 0.3, 0.0)
PASSES = 8


def placed(position: Any) -> Any:
    """Return where the light is, at a position, facing the dragon."""
    origin, target = ([SIZE * float(x) for x in point] for point in (position, AIM))
    turn = mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 1, 0])
    return mi.Transform4f((turn @ mi.ScalarTransform4f().scale(HALF_SIDE * SIZE)).matrix)


def timed(viewer: Viewer, count: int) -> tuple[NDArray, dict[str, float]]:
    """Return milliseconds of frames with the light at `count` places around the dragon, and medians of their parts."""
    light, every, parts = viewer.light("light"), [], []
    for angle in 2 * np.pi * np.arange(-2, count) / count:
        start = time.perf_counter()
        light["to_world"] = placed((1.27 * np.cos(angle), 1.6, 1.27 * np.sin(angle)))
        light.update()
        viewer.frame()
        every.append(1e3 * (time.perf_counter() - start))
        parts.append(dict(viewer.seconds))
    return np.array(every[2:]), {
        name: 1e3 * float(np.median([part[name] for part in parts])) for name in parts[0]
    }


def walked(b1: Any, position: Any, spp: int) -> Estimate:
    """Return the walk's picture."""
    parameters = mi.traverse(b1)
    parameters["light.to_world"] = placed(position)
    parameters.update()
    walk: Any = mi.load_dict({"type": "translucent_path", "model": "walk"})
    each = max(spp // PASSES, 1)
    passes = [mi.render(b1, integrator=walk, spp=each, seed=i).numpy()[..., :3] for i in range(PASSES)]  # type: ignore[arg-type]
    return Estimate(np.mean(passes, axis=0), np.std(passes, axis=0, ddof=1) / PASSES**0.5)


def compared(frame: NDArray, walk: Estimate, mask: NDArray) -> str:
    """Return bias, error and worst block in words."""
    found = difference(Estimate(frame, np.zeros_like(frame)), walk, mask)
    values = [100 * x for x in (found.bias, found.error, found.error_error, found.worst, found.worst_error)]
    return "bias {:+.1f} %, error {:.1f} +- {:.1f} %, worst block {:+.0f} +- {:.0f} %".format(*values)


def main() -> None:
    """Print times and biases."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spp", type=int, default=0)
    parser.add_argument("--positions", type=int, default=36)
    parser.add_argument("--transport", type=Path)
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    b1 = scene()
    print(f"Nephrite {nephrite.__version__}, {mi.variant()}, scene B1")
    start = time.perf_counter()
    kept = given.transport is not None and given.transport.exists()
    transport = load(given.transport) if kept else precompute(b1)
    print(f"{'loading' if kept else 'precomputation'}: {time.perf_counter() - start:.2f} s")
    if given.transport is not None and not kept:
        transport.save(given.transport)
    start = time.perf_counter()
    viewer = Viewer(b1, transport)
    print(f"the viewer: {time.perf_counter() - start:.1f} s")
    start = time.perf_counter()
    viewer.frame()
    seconds = viewer.seconds["camera"]
    print(f"its first frame: {time.perf_counter() - start:.1f} s, {seconds:.1f} s of it for the camera")
    every, parts = timed(viewer, given.positions)
    print(
        f"a frame with a moved light: median {np.median(every):.0f} ms, {every.min():.0f} to {every.max():.0f} ms"
    )
    print("of it: " + ", ".join(f"{name} {ms:.1f} ms" for name, ms in parts.items()))
    if not given.spp:
        return
    mask = object_mask(b1)
    for name, position in (("own", OWN), ("front", FRONT)):
        walk = walked(b1, position, given.spp)
        viewer.light("light").update()
        frame = viewer.frame()
        print(f"{name} light, object: {compared(frame, walk, mask)}")
        print(f"{name} light, around: {compared(frame, walk, ~mask)}")
        if given.pictures is not None:
            page = figure.side_by_side([frame, walk.mean], ["viewer, one frame", "walk"])
            write.save(given.pictures / f"relight-{name}.png", page)


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
