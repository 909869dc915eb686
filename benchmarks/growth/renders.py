"""A peer's process for growth: two pictures with a given number of samples, and what is paid but once.

    python -m benchmarks.growth.renders JOB.json

JOB.json holds `peer`, a module in benchmarks/peers, its `scene` and `method` (see benchmarks/peers/measure.py), `seed`,
`spp` and `folder`. Nephrite's integrator is kept from call to call, as it is while lights, camera or seed change: what
it precomputes is in the `first` call with it alone. Kernels are compiled, and scenes prepared, by a call before that.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.measure import Renderer, peak_memory


def main() -> None:
    """Do the job that the command line names; writes `pictures.npz` and `told.json` into its folder."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    start = time.perf_counter()
    renderer, renew, computed = prepare(job)
    loaded = time.perf_counter() - start
    told, pictures = timed(renderer, renew, job["seed"], job["spp"])
    told |= {"version": renderer.version, "loaded": loaded, "peak": peak_memory(), "computed": computed()}
    folder = Path(job["folder"])
    np.savez(folder / "pictures.npz", **pictures)
    (folder / "told.json").write_text(json.dumps(told), encoding="utf-8")


def prepare(job: dict[str, Any]) -> tuple[Renderer, Callable[[], None], Callable[[], str]]:
    """Return the loaded scene, a function after which nothing is precomputed any more, and one for what was computed.

    The latter: the model that Nephrite has chosen where the one asked for does not apply; nothing for others.
    """
    peer = importlib.import_module(f"benchmarks.peers.{job['peer']}")
    if job["peer"] != "mitsuba":
        return peer.prepare(job["scene"], job["method"]), lambda: None, lambda: ""
    import mitsuba as mi

    mi.set_variant(job["method"]["variant"])
    scene, kept = peer.load(job["scene"]), {}

    def renew() -> None:
        kept["integrator"] = mi.load_dict(job["method"]["integrator"])

    def call(spp: int, seed: int) -> Any:
        return mi.render(scene, integrator=kept["integrator"], spp=spp, seed=seed).numpy()[..., :3]  # type: ignore[arg-type]

    def computed() -> str:
        return "; ".join(choice.model for choice in getattr(kept["integrator"], "choices", []))

    renew()
    return Renderer(call, f"Mitsuba {mi.__version__}, {mi.variant()}"), renew, computed


def timed(
    renderer: Renderer,
    renew: Callable[[], None],
    seed: int,
    spp: int,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return seconds of calls, and the pictures `a` and `b`.

    `first`: of the first call with `spp` samples since nothing was precomputed; `again`: of two more; `once`: of a call
    with one sample, 0 unless each call starts up anew.
    """
    seconds: list[float] = []

    def call(samples: int) -> Any:
        before = clock()
        picture = renderer.call(samples, seed + len(seconds))
        seconds.append(clock() - before)
        return np.asarray(picture, np.float32)

    call(spp)
    once = 0.0
    if renderer.startup:
        call(1)
        call(1)
        once = min(seconds[-2:])
    renew()
    call(spp)
    a, b = call(spp), call(spp)
    told = {"spp": spp, "first": seconds[-3], "again": seconds[-2:], "once": once}
    return told, {"a": a, "b": b}


if __name__ == "__main__":
    main()
