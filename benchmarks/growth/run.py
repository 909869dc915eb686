"""Time and memory as scenes grow: triangles, optical thickness, resolution and g; how soon a first picture is there.

    make growth                         # all of it, some 12 minutes; again: what is missing
    make growth GROWTH=--quick          # small pictures: whether everything works
    .venv/bin/python -m benchmarks.growth --seconds 300 --only first resolution

Everything is benchmark scene B1, changed in one thing at a time. Each method renders in a process of its own; results
are kept in out/bench/growth, and a run that was interrupted goes on. Changed code starts anew. The page is
docs/growth.md, its plots docs/figures/growth.
"""

from __future__ import annotations

import argparse
import datetime
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import analysis, methods, runner, scenes
from benchmarks.growth import as_user, numbers, page
from benchmarks.growth.asked import METHODS, Results
from benchmarks.growth.numbers import Numbers, Point
from benchmarks.store import Pictures, Store
from nephrite.atlas.compared import difference

ROOT = runner.ROOT
SECTIONS = ("first", "resolution", "triangles", "size", "g")
DRAGONS = ("dragon-tiny", "dragon-small", "dragon", "dragon-full")
# spp: samples of a picture; few: of pictures that take long; good: that `transport` and the denoiser need
FULL = {
    "resolution": (400, 300), "spp": 8, "dragons": DRAGONS, "sizes": (10.0, 30.0, 100.0, 300.0, 1000.0),
    "gs": (0.0, 0.5, 0.9), "pictures": ((400, 300), (1920, 1080), (3840, 2160)), "time": "7s", "repeats": 2,
    "few": 2, "good": 4,
}  # fmt: skip
QUICK = {
    "resolution": (100, 75), "spp": 2, "dragons": DRAGONS[:2], "sizes": (10.0, 1000.0),
    "gs": (0.0, 0.9), "pictures": ((80, 60), (160, 120)), "time": "2s", "repeats": 1,
    "few": 2, "good": 2,
}  # fmt: skip
LARGEST = 6e4  # what is kept of a firefly: half precision ends there
B1 = scenes.SCENES[0]
COMMAND = ("render", B1.object, "--material", "skim milk", "--light", "benchmark")


def options() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="small pictures; page in out/bench-quick")
    parser.add_argument("--seconds", type=float, default=1500.0, help="nothing new is begun after this time")
    parser.add_argument("--only", nargs="*", default=SECTIONS, choices=SECTIONS, help="what is measured")
    parser.add_argument("--peers", type=Path, default=ROOT / ".venv-bench/bin/python", help="their Python")
    return parser.parse_args()


def anisotropic(scene: dict[str, Any], g: float) -> dict[str, Any]:
    """Return a described scene whose medium has another `g`, and the same sigma_s' = sigma_s (1 - g)."""
    if g == scene["g"]:
        return scene
    return {**scene, "g": g, "sigma_s": [s * (1 - scene["g"]) / (1 - g) for s in scene["sigma_s"]]}


class Growth:
    """One run: what is to be measured, and what has been."""

    def __init__(self, given: argparse.Namespace) -> None:
        """Find out what can run here; raises `LeftOutError` where there is no dragon."""
        self.given, self.start = given, time.monotonic()
        self.plan: dict[str, Any] = QUICK if given.quick else FULL
        self.folder = ROOT / ("out/bench-quick/growth" if given.quick else "out/bench/growth")
        self.store = Store(self.folder)
        self.sources = runner.sources(
            *(f"growth/{name}.py" for name in ("renders", "command", "as_user", "numbers"))
        )
        self.left_out: dict[str, str] = {}
        self.methods = {method.name: method for method in methods.all_methods(gpu=False)}
        packages = [self.methods[name].package for name in METHODS]
        for package, why in runner.missing(sorted({p for p in packages if p}), given.peers).items():
            self.left_out[package] = why
        self._scenes: dict[tuple[str, float], dict[str, Any]] = {}
        self._scene(B1.object, B1.size)  # nothing can be measured without it

    def run(self) -> Results:
        """Measure everything that is asked for and that there is time for."""
        found = {name: getattr(self, name)() for name in SECTIONS}
        return Results(**found)

    def first(self) -> list[tuple[Numbers, NDArray[np.uint8]]]:
        """Return times of first pictures, and these: without kernels that were compiled before, and with them."""
        runs = []
        ways = {"walk": ["--time", self.plan["time"]], "transport": ["--spp", str(self.plan["good"])]}
        for model, until in ways.items():
            for number in range(self.plan["repeats"]):
                for cold in (True, False):
                    arguments = self._arguments(self.plan["resolution"], model, until)
                    job = {"arguments": [*arguments, "--seed", str(number)], "cold": cold}
                    name = f"first/{model}-{number}-{'cold' if cold else 'warm'}"
                    runs.append(self._kept("first", name, job, as_user.from_outside))
        return [(told, pictures["shown"]) for told, pictures in filter(None, runs)]

    def resolution(self) -> list[Point]:
        """Return seconds and memory of the command line, by pixels."""
        points = []
        for width, height in self.plan["pictures"]:
            point = Point(width * height)
            for model in ("walk", "transport"):
                job = {"arguments": self._arguments((width, height), model, ["--spp", str(self.plan["few"])])}
                found = self._kept(
                    "resolution", f"resolution/{width}x{height}-{model}", job, as_user.with_memory
                )
                if found:
                    point.of[model] = found[0]
            points.append(point)
        return points

    def triangles(self) -> list[Point]:
        """Return what a picture costs, by the triangles of the dragon."""
        points = []
        for name in self.plan["dragons"]:
            scene = self._scene(name, B1.size)
            points.append(self._point("triangles", scene["triangles"], scene, METHODS))
        return points

    def size(self) -> list[Point]:
        """Return the same, by the size of the body, which its optical thickness is proportional to."""
        chosen = [name for name in METHODS if name != "volpathmis"]
        return [
            self._point("size", size, self._scene(B1.object, size), chosen) for size in self.plan["sizes"]
        ]

    def g(self) -> list[Point]:
        """Return the same, by g at equal sigma_s', with the difference of the picture at g = 0 from each."""
        points, isotropic = [], {}
        for g in self.plan["gs"]:
            scene, point = anisotropic(self._scene(B1.object, B1.size), g), Point(g)
            for name in ("walk", "transport"):
                found = self._measured("g", scene, self.methods[name])
                if found is None:
                    continue
                point.of[name] = dict(found[0])
                picture = analysis.mean_of([(found[1]["a"], found[1]["b"])])
                if g == 0.0:
                    isotropic[name] = picture
                elif name in isotropic:
                    off = difference(isotropic[name], picture, self._mask(scene))
                    point.of[name]["similarity"] = asdict(off)
            points.append(point)
        return points

    def _point(self, section: str, at: float, scene: dict[str, Any], names: Any) -> Point:
        found = {name: self._measured(section, scene, self.methods[name]) for name in names}
        return Point(at, {name: result[0] for name, result in found.items() if result})

    def _measured(self, section: str, scene: dict[str, Any], method: methods.Method) -> Any:
        """Return a method's numbers and pictures of a scene; sections share them."""
        if method.package in self.left_out:
            return None
        spp = self.plan["few" if method.name == "volpathmis" else "spp"]
        job = {
            "scene": scene, "peer": method.peer, "method": method.settings, "spp": spp, "seed": 1000,
            "python": str(runner.python_of(method, self.given.peers)),
        }  # fmt: skip
        name = f"{Path(scene['mesh']).stem}-g{scene['g']:g}/{method.name}"
        return self._kept(section, name, job, self._rendered)

    def _rendered(self, job: dict[str, Any]) -> tuple[Numbers, Pictures]:
        told, pictures = runner.run(
            "benchmarks.growth.renders", Path(job["python"]), job, runner.LIMIT, runner.pictures
        )
        found = {name: told[name] for name in ("spp", "loaded", "peak", "version", "computed")}
        found |= numbers.cost(told)
        found["variance"] = numbers.variance(pictures["a"], pictures["b"], self._mask(job["scene"]))
        return found, {name: np.minimum(p, LARGEST).astype(np.float16) for name, p in pictures.items()}

    def _kept(self, section: str, name: str, job: dict[str, Any], make: Any) -> Any:
        """Return what was kept of a job, or `make` it and keep it; None if it fails, or there is no time for it."""
        asked = {**job, "sources": self.sources}
        found = self.store.load(name, asked)
        if found or section not in self.given.only or time.monotonic() - self.start > self.given.seconds:
            return found
        print(f"[{(time.monotonic() - self.start) / 60:5.1f} min] {section}: {name}", flush=True)
        try:
            told, pictures = make(job)
        except runner.FailedError as error:
            self.left_out[name] = str(error)
            print(f"left out: {name}: {error}", flush=True)
            return None
        now = datetime.datetime.now(datetime.timezone.utc)
        told["date"] = now.isoformat(timespec="minutes")
        self.store.save(name, asked, told, pictures)
        return told, pictures

    def _scene(self, name: str, size: float) -> dict[str, Any]:
        """Return B1 with another object, or another size of everything in it."""
        key = (name, size)
        if key not in self._scenes:
            changed = replace(B1, object=name, size=size)
            self._scenes[key] = scenes.described(changed, self.plan["resolution"], self.folder / "meshes")
        return self._scenes[key]

    def _mask(self, scene: dict[str, Any]) -> NDArray[np.bool_]:
        from benchmarks.peers.mitsuba import load
        from nephrite.scene.translucent import object_mask

        return object_mask(load(scene))

    def _arguments(self, resolution: tuple[int, int], model: str, until: list[str]) -> list[str]:
        width, height = resolution
        return [*COMMAND, "--resolution", f"{width}x{height}", "--model", model, *until, "-o", "picture.png"]


def main() -> None:
    """Run, and write the page."""
    import mitsuba as mi

    given = options()
    try:
        growth = Growth(given)
    except scenes.LeftOutError as error:
        sys.exit(str(error))
    mi.set_variant("llvm_ad_rgb")
    results = growth.run()
    target = ROOT / "docs/growth.md" if not given.quick else growth.folder.parent / "growth.md"
    titles = {name: method.title for name, method in growth.methods.items()}
    print(page.write(target, results, titles, growth.left_out, growth.plan, given.quick))
