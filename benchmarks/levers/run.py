"""What each lever is worth: benchmark scene B1 rendered with all of them, and without each in turn.

    .venv/bin/python -m benchmarks.levers             # some 20 minutes; again: what is missing
    .venv/bin/python -m benchmarks.levers --quick     # small pictures, into out/bench-quick: whether everything works

Each in a process of its own, in rounds, with all levers at the beginning of each: ratios are to that round's. Results
are kept in out/bench; changed code starts anew. The page is docs/levers.md.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks import runner, scenes
from benchmarks.levers import page
from benchmarks.levers.patches import LEVERS, TRANSPORT, WALK
from benchmarks.store import Store

FULL = {"resolution": "400x300", "spp": {WALK: 32, TRANSPORT: 64}, "rounds": 2}
QUICK = {"resolution": "60x45", "spp": {WALK: 4, TRANSPORT: 4}, "rounds": 1}
LIMIT = 1200.0  # seconds for each


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="small pictures, one round; page in out/bench-quick"
    )
    parser.add_argument("--rounds", type=int, help="repetitions, which tell how sure the figures are")
    parser.add_argument("--models", nargs="*", choices=list(LEVERS), default=list(LEVERS))
    quick, models = (given := parser.parse_args()).quick, given.models
    settings: dict[str, Any] = dict(QUICK if quick else FULL)
    settings["rounds"] = given.rounds or settings["rounds"]
    folder = runner.ROOT / ("out/bench-quick" if quick else "out/bench")
    store = Store(folder)
    sources = runner.sources(*(f"levers/{name}.py" for name in ("job", "patches", "where", "noise")))
    width, height = (int(side) for side in settings["resolution"].split("x"))
    b1 = next(scene for scene in scenes.SCENES if scene.name == "b1")
    described = scenes.described(b1, (width, height), folder / "meshes")
    found: dict[str, dict[str, list[dict[str, Any]]]] = {model: {} for model in models}
    for number in range(settings["rounds"]):
        for model in models:
            for lever in ("", *(one.name for one in LEVERS[model])):
                job = {"scene": described, "model": model, "lever": lever, "spp": settings["spp"][model]}
                asked, file = {**job, "sources": sources}, f"levers/{model}-{lever or 'all'}-{number}"
                kept = store.load(file, asked)
                if kept is None:
                    print(f"round {number + 1}: {model} without {lever or 'nothing'}", flush=True)
                    # an empty home has no kernels that others have compiled, so that compiling is seen
                    with tempfile.TemporaryDirectory() as home, mock.patch.dict(os.environ, HOME=home):
                        told = runner.run("benchmarks.levers.job", Path(sys.executable), job, LIMIT, _told)
                    now = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="minutes")
                    kept = ({**told, "date": now}, {})
                    store.save(file, asked, *kept)
                found[model].setdefault(lever, []).append(kept[0])
    target = folder / "levers.md" if quick else runner.ROOT / "docs/levers.md"
    print(page.write(target, found, settings))


def _told(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "told.json").read_text(encoding="utf-8"))
