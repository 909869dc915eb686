"""Results as files, one JSON and one NPZ for each process, so that a benchmark that was interrupted goes on."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Pictures = dict[str, NDArray]


class Store:
    """A folder of results, each known by its name and by what was asked for."""

    def __init__(self, folder: Path) -> None:
        """Keep results in `folder`, which is made."""
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def load(self, name: str, asked: dict[str, Any]) -> tuple[dict[str, Any], Pictures] | None:
        """Return a result's numbers and pictures; None if there is none, or it answers another question."""
        try:
            found = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))
            if found["key"] != key(asked):
                return None
            with np.load(self.folder / f"{name}.npz") as file:
                return found["numbers"], {name: file[name] for name in file.files}
        except (OSError, ValueError, KeyError):
            return None

    def save(self, name: str, asked: dict[str, Any], numbers: dict[str, Any], pictures: Pictures) -> None:
        """Keep a result; the pictures first, so that a result without them is none."""
        path = self.folder / f"{name}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        np.savez_compressed(path.with_suffix(".npz"), **pictures)  # type: ignore[arg-type]
        path.write_text(json.dumps({"key": key(asked), "numbers": numbers}), encoding="utf-8")


def key(asked: dict[str, Any]) -> str:
    """Return a digest of what was asked for."""
    return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:24]
