"""Results that took long, kept in files: an atlas that was interrupted goes on where it stopped."""

from __future__ import annotations

import hashlib
import io
import json
import math
import time
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite import __version__
from nephrite.scene.ply import write_atomically

__all__ = ["Cell", "NotYetError", "Store"]

Cell = dict[str, NDArray[Any]]
"""What is known of one simulation or picture: named arrays, some of a single number."""


class NotYetError(Exception):
    """A cell is not there, and the time in which it could be computed is over."""


class Store:
    """Cells by what they depend on: in memory, and a file each in `folder` (made when needed; None: in memory alone).

    After `seconds`, no cell is computed any more. `on_cell` is called with the label of each cell before it is.
    `fresh`: files of earlier runs are not read, but replaced.
    """

    def __init__(
        self,
        folder: Path | None,
        seconds: float = math.inf,
        on_cell: Callable[[str], None] = lambda label: None,
        fresh: bool = False,
    ) -> None:
        """Open the store; nothing is read yet."""
        self.folder, self.on_cell, self.fresh = folder, on_cell, fresh
        self.end = time.monotonic() + seconds
        self.made = 0
        """Cells that were not there and had to be computed."""
        self._known: dict[str, Cell] = {}

    @property
    def seconds(self) -> float:
        """How long all cells that were asked for took to compute, in this run or in earlier ones."""
        return sum(float(cell["seconds"]) for cell in self._known.values())

    def cell(self, label: str, parameters: Mapping[str, Any], compute: Callable[[], Cell]) -> Cell:
        """Return the cell of these `parameters` (anything that JSON can hold), from its file or computed.

        Nephrite's version belongs to the key. A damaged file counts as none. Raises `NotYetError` once time is over.
        """
        text = json.dumps({"version": __version__, "cell": dict(parameters)}, sort_keys=True)
        name = f"{label.split()[0]}-{hashlib.sha256(text.encode()).hexdigest()[:20]}.npz"
        if name not in self._known:
            path = self.folder / name if self.folder else None
            found = None if path is None or self.fresh else _read(path)
            self._known[name] = found or self._computed(label, compute, path)
        return self._known[name]

    def _computed(self, label: str, compute: Callable[[], Cell], path: Path | None) -> Cell:
        if time.monotonic() > self.end:
            raise NotYetError(label)
        self.on_cell(label)
        start = time.perf_counter()
        found = {key: np.asarray(value) for key, value in compute().items()}
        found["seconds"] = np.asarray(time.perf_counter() - start)
        self.made += 1
        if path is not None:
            buffer = io.BytesIO()
            np.savez_compressed(buffer, **found)  # pyright: ignore[reportArgumentType]
            write_atomically(path, buffer.getvalue())
        return found


def _read(path: Path) -> Cell | None:
    try:
        with np.load(io.BytesIO(path.read_bytes())) as file:
            return {key: file[key] for key in file.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
