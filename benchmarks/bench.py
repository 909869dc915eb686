"""Nephrite beside its peers on the benchmark's scenes: error over time, at equal materials, in one run.

    make bench                          # all of it, some two hours; again: what is missing
    make bench BENCH=--quick            # small pictures, a few minutes: whether everything works
    .venv/bin/python -m benchmarks.bench --seconds 3600 --scenes b1 --methods walk cycles volpathmis

Each method renders in a process of its own, in turn, in several rounds; results are kept in out/bench, and a run that
was interrupted goes on. Changed code starts anew, but for the references. The page is docs/benchmark.md.
"""

from __future__ import annotations

import argparse
import datetime
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import analysis, methods, page, runner, scenes
from benchmarks.store import Store
from nephrite.atlas.compared import Estimate

ROOT = runner.ROOT
FULL = {"resolution": "400x300", "each": 20.0, "rounds": 3, "reference": 1500.0, "seconds": 9000.0}
QUICK = {"resolution": "100x75", "each": 2.0, "rounds": 1, "reference": 10.0, "seconds": 600.0}
NOISE = 0.01  # of a reference: relative variance at which it ends
LARGEST = 6e4  # what is kept of a firefly: half precision ends there


def options() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="small pictures, one round; page in out/bench-quick"
    )
    parser.add_argument("--seconds", type=float, help="nothing new is begun after this time")
    parser.add_argument("--each", type=float, help="seconds of rendering for each scene, method and round")
    parser.add_argument("--rounds", type=int, help="repetitions, from whose spread ratios get theirs")
    parser.add_argument("--reference", type=float, help="most seconds for B1's reference; others: a third")
    parser.add_argument("--resolution", help="WIDTHxHEIGHT")
    parser.add_argument("--scenes", nargs="*", default=[scene.name for scene in scenes.SCENES])
    parser.add_argument("--methods", nargs="*", default=[], help="names as in benchmarks/methods.py")
    parser.add_argument("--peers", type=Path, default=ROOT / ".venv-bench/bin/python", help="their Python")
    parser.add_argument("--gpu", action="store_true", help="Nephrite's methods in cuda_ad_rgb too")
    given = parser.parse_args()
    for name, value in (QUICK if given.quick else FULL).items():
        if getattr(given, name) is None:
            setattr(given, name, value)
    return given


class Bench:
    """One run: what is to be rendered, and what has been."""

    def __init__(self, given: argparse.Namespace) -> None:
        """Find out what can run here."""
        self.given, self.start = given, time.monotonic()
        self.folder = ROOT / ("out/bench-quick" if given.quick else "out/bench")
        self.store = Store(self.folder)
        self.left_out: dict[str, str] = {}
        width, height = (int(side) for side in given.resolution.split("x"))
        self.resolution = (width, height)
        self.methods = self._methods()
        self.described = self._scenes()
        self.sources = runner.sources()

    def _methods(self) -> list[methods.Method]:
        every = methods.all_methods(self.given.gpu)
        chosen = [m for m in every if not self.given.methods or m.name in self.given.methods]
        for method in every:
            if method not in chosen:
                self._leave_out(method.title, "not asked for in this run")
        lacking = runner.missing(sorted({m.package for m in chosen if m.package}), self.given.peers)
        for method in chosen:
            if method.package in lacking:
                self._leave_out(method.title, f"`{method.package}`: {lacking[method.package]}")
        return [method for method in chosen if method.package not in lacking]

    def _scenes(self) -> dict[str, dict[str, Any]]:
        found = {}
        for scene in scenes.SCENES:
            if scene.name not in self.given.scenes:
                continue
            try:
                found[scene.name] = scenes.described(scene, self.resolution, self.folder / "meshes")
            except scenes.LeftOutError as error:
                self._leave_out(scene.title, str(error))
        return found

    def _leave_out(self, what: str, why: str) -> None:
        self.left_out[what] = why
        print(f"left out: {what}: {why}", flush=True)

    @property
    def in_time(self) -> bool:
        """Whether something new may begin."""
        return time.monotonic() - self.start < self.given.seconds

    def truth(self, name: str) -> analysis.Truth | None:
        """Return a scene's reference, rendered if there is none yet and there is time."""
        share = next(scene.reference for scene in scenes.SCENES if scene.name == name)
        seconds = share * self.given.reference
        job = {
            "scene": self.described[name],
            "integrator": methods.REFERENCE,
            "variant": "cuda_ad_rgb" if self.given.gpu else "llvm_ad_rgb",
            "noise": NOISE,
            "seconds": seconds,
        }
        found = self.store.load(f"{name}/reference", job)
        if found is None:
            if not self.in_time:
                return None
            self._say(f"{name}: reference, up to {seconds:.0f} s")
            limit = 10 * seconds + 600
            try:
                pictures = runner.run("benchmarks.reference", Path(sys.executable), job, limit, runner.truth)
            except runner.FailedError as error:
                self._leave_out(f"{name}, which has no reference", str(error))
                return None
            found = ({}, pictures)
            self.store.save(f"{name}/reference", job, *found)
        pictures = found[1]
        mean, error = (pictures[key].astype(np.float64) for key in ("mean", "error"))
        return analysis.Truth(Estimate(mean, error), pictures["mask"].astype(bool))

    def measured(self, name: str, method: methods.Method, number: int, truth: analysis.Truth) -> Any:
        """Return a round of a method, numbers and pictures; None if it has failed or there is no time."""
        job = {
            "scene": self.described[name],
            "method": method.settings,
            "seed": 1000 * (number + 1),
            "seconds": self.given.each,
        }
        asked = {**job, "reference": self.given.reference, "sources": self.sources}
        file = f"{name}/{method.name}-{number}"
        found = self.store.load(file, asked)
        if found is not None or not self.in_time:
            return found
        self._say(f"{name}: round {number + 1}, {method.title}")
        module, limit = f"benchmarks.peers.{method.peer}", 20 * self.given.each + 300
        try:
            told, pictures = runner.run(
                module, runner.python_of(method, self.given.peers), job, limit, runner.pictures
            )
        except runner.FailedError as error:
            self._leave_out(f"{method.title} ({name})", str(error))
            return None
        levels = told["levels"]
        curve = [
            analysis.level(pictures[f"a{i}"], pictures[f"b{i}"], level["spp"], level["seconds"], truth)
            for i, level in enumerate(levels)
        ]
        width, height = self.resolution
        numbers = {
            "curve": curve,
            "samples": levels[-1]["spp"] * width * height,
            "peak": told["peak"],
            "loaded": told["loaded"],
            "version": told["version"],
            "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="minutes"),
        }
        last = {
            key: np.minimum(pictures[f"{key}{len(levels) - 1}"], LARGEST).astype(np.float16) for key in "ab"
        }
        self.store.save(file, asked, numbers, last)
        return numbers, last

    def run(self) -> list[page.SceneResult]:
        """Render everything that there is time for; rounds come one after the other, so that all methods have one."""
        truths = {name: truth for name in self.described if (truth := self.truth(name)) is not None}
        found: dict[str, dict[str, list[Any]]] = {name: {} for name in truths}
        failed: set[tuple[str, str]] = set()
        for number in range(self.given.rounds):
            for name, truth in truths.items():
                for method in self.methods:
                    if (name, method.name) in failed or (method.name in methods.ONCE and number > 0):
                        continue
                    result = self.measured(name, method, number, truth)
                    if result is not None:
                        found[name].setdefault(method.name, []).append(result)
                    elif self.in_time:
                        failed.add((name, method.name))
        return [
            page.SceneResult(scene, self.described[scene.name], truths[scene.name], found[scene.name])
            for scene in scenes.SCENES
            if found.get(scene.name)
        ]

    def _say(self, text: str) -> None:
        print(f"[{(time.monotonic() - self.start) / 60:5.1f} min] {text}", flush=True)


def main() -> None:
    """Run, and write the page."""
    import mitsuba as mi

    given = options()
    bench = Bench(given)
    mi.set_variant("llvm_ad_rgb")
    results = bench.run()
    target = bench.folder / "benchmark.md" if given.quick else ROOT / "docs/benchmark.md"
    print(page.write(target, results, bench.methods, bench.left_out, vars(given)))


if __name__ == "__main__":
    main()
