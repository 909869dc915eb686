"""Starts a process for each job, in the environment that its renderer lives in."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import nephrite
from benchmarks.methods import Method

ROOT = Path(__file__).parents[1]
LIMIT = 900.0  # seconds, after which a process has failed that was not given a time


class FailedError(Exception):
    """A process that has not brought a result."""


def python_of(method: Method, peers: Path) -> Path:
    """Return the interpreter that runs a method; `peers` is that of the peers' environment."""
    return peers if method.package else Path(sys.executable)


def missing(packages: list[str], peers: Path) -> dict[str, str]:
    """Return the packages that the peers' environment can't import, and why."""
    if not peers.exists():
        return dict.fromkeys(packages, f"there is no {peers}; `make bench` makes it")
    found = {}
    for package in packages:
        done = subprocess.run([str(peers), "-c", f"import {package}"], capture_output=True, text=True)
        if done.returncode != 0:
            found[package] = last_line(done.stderr)
    return found


def run(module: str, python: Path, job: dict[str, Any], limit: float, results: Callable[[Path], Any]) -> Any:
    """Run `module` on a job and return `results(folder)`; raises `FailedError` that says what went wrong."""
    with tempfile.TemporaryDirectory(prefix="nephrite-bench-") as name:
        folder = Path(name)
        file = folder / "job.json"
        file.write_text(json.dumps({**job, "folder": name}), encoding="utf-8")
        paths = [str(ROOT)] + ([os.environ["PYTHONPATH"]] if "PYTHONPATH" in os.environ else [])
        try:
            done = subprocess.run(
                [str(python), "-m", module, str(file)],
                capture_output=True, text=True, timeout=limit, cwd=folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            )  # fmt: skip
        except subprocess.TimeoutExpired as error:
            raise FailedError(f"it took more than {limit:.0f} s") from error
        if done.returncode != 0:
            raise FailedError(f"exit status {done.returncode}: {last_line(done.stderr)}")
        return results(folder)


def pictures(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read what `peers.measure` writes: numbers and pictures."""
    told = json.loads((folder / "told.json").read_text(encoding="utf-8"))
    with np.load(folder / "pictures.npz") as file:
        return told, {name: file[name] for name in file.files}


def truth(folder: Path) -> dict[str, Any]:
    """Read what `benchmarks.reference` writes."""
    with np.load(folder / "truth.npz") as file:
        return {name: file[name] for name in file.files}


def sources(*more: str) -> str:
    """Return a digest of the code that is measured and of the code that measures; `more`: files in benchmarks/."""
    here = Path(__file__).parent
    files = [*Path(nephrite.__file__).parent.rglob("*.py"), *here.glob("peers/*.py"), here / "analysis.py"]
    files += [here / name for name in more]
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()


def last_line(text: str) -> str:
    """Return the last line that says something: of a traceback, the error."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it said nothing"
