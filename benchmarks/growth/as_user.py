"""Runs Nephrite's command line as a user does, and returns how long it took, and what its picture says about itself.

A job has `arguments`, those of `nephrite`, which end by writing picture.png.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks import runner
from benchmarks.growth.numbers import Numbers
from benchmarks.store import Pictures
from nephrite.image.write import read_metadata
from nephrite.scene import cache


def with_memory(job: dict[str, Any]) -> tuple[Numbers, Pictures]:
    """Run the command line, and return its time, its memory, and what its picture says about itself."""

    def results(folder: Path) -> Numbers:
        told = json.loads((folder / "told.json").read_text(encoding="utf-8"))
        return {**told, "notes": read_metadata(folder / "picture.png")}

    return runner.run("benchmarks.growth.command", Path(sys.executable), job, runner.LIMIT, results), {}


def from_outside(job: dict[str, Any]) -> tuple[Numbers, Pictures]:
    """Time the command from outside; `cold`: with an empty home, where Dr.Jit finds no compiled kernels."""
    with tempfile.TemporaryDirectory(prefix="nephrite-bench-") as name:
        file = Path(name) / "picture.png"
        home = {"HOME": name, cache.ENVIRONMENT_VARIABLE: str(cache.folder())} if job["cold"] else {}
        start = time.perf_counter()
        done = subprocess.run(
            [str(Path(sys.executable).with_name("nephrite")), *job["arguments"]],
            cwd=name, env={**os.environ, **home}, capture_output=True, text=True,
        )  # fmt: skip
        seconds = time.perf_counter() - start
        if done.returncode:
            raise runner.FailedError(runner.last_line(done.stderr))
        numbers = {"seconds": seconds, "cold": job["cold"], "notes": read_metadata(file)}
        return numbers, {"shown": np.asarray(Image.open(file).convert("RGB"))}
