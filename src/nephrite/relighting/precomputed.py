"""Transport as it is kept in a file: nodes and operators of each surface, and the key of mesh and medium."""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from nephrite.errors import ParameterError
from nephrite.image import write
from nephrite.plugins import auto, collector
from nephrite.plugins.kept import LOST
from nephrite.plugins.media import WALK, Media
from nephrite.plugins.transport import Transport
from nephrite.plugins.winding import triangles
from nephrite.transport.grids import GRIDS
from nephrite.transport.pyramid import Pyramid

FORMAT = "nephrite transport 2"

Key = dict[str, Any]


@dataclass
class Precomputed:
    """What light does under the surfaces of a scene, whatever its lights and camera.

    `layouts`: nodes, normals and spacing of each surface (see `plugins.lookup`); `operators`: one a surface; `keys`:
    what they belong to.
    """

    layouts: list[tuple[NDArray, NDArray, float]]
    operators: list[Pyramid]
    keys: list[Key]

    def save(self, path: str | os.PathLike) -> None:
        """Write a file, NumPy's NPZ, in one step; raises `ParameterError` if the path cannot be written."""
        arrays: dict[str, NDArray] = {}
        for i, ((points, normals, spacing), operator) in enumerate(
            zip(self.layouts, self.operators, strict=True)
        ):
            arrays |= {f"{i}.points": points, f"{i}.normals": normals, f"{i}.spacing": np.array(spacing)}
            arrays |= {f"{i}.facing{grid}": operator.facing[grid] for grid in range(1, GRIDS)}
            for name, matrices in _matrices(operator).items():
                first = matrices[0]
                arrays |= {
                    f"{i}.{name}.data": np.stack([matrix.data for matrix in matrices]),
                    f"{i}.{name}.indices": first.indices,
                    f"{i}.{name}.indptr": first.indptr,
                    f"{i}.{name}.shape": np.array(first.shape),
                }
        about = json.dumps({"format": FORMAT, "keys": self.keys})
        stream = io.BytesIO()
        np.savez(stream, about=np.array(about), **arrays)  # type: ignore[arg-type]
        write.save_bytes(path, stream.getvalue())

    def check(self, members: list[tuple[Any, Any]]) -> None:
        """Raise `ParameterError`, naming what differs, unless this belongs to `members`, entries and shapes."""
        own = keys(members)
        if len(own) != len(self.keys):
            raise ParameterError(
                f"the transport is that of {len(self.keys)} translucent shapes, but the scene has {len(own)}: "
                "precompute it for this scene."
            )
        for number, (there, here) in enumerate(zip(self.keys, own, strict=True)):
            for name, value in here.items():
                if there[name] != value:
                    shown = "" if name == "shape" else f": {there[name]} there, {value} here"
                    raise ParameterError(
                        f"the transport does not belong to shape {number + 1} of the scene: another {name}{shown}. "
                        "Precompute it for this scene."
                    )


@collector.kept_off()
def precompute(scene: Any, walks: int = 1_500_000) -> Precomputed:
    """Walk through all translucent objects of a scene, `walks` times each.

    Raises `ParameterError` for objects that transport does not hold for.
    """
    members = surfaces(scene)
    found = Transport(scene, members, walks, relative=False)
    for (_, shape), surface in zip(members, found.surfaces, strict=True):
        if surface.lost > LOST:
            raise ParameterError(
                f"shape {shape.id()!r} has another object inside: transport does not know of it. Take it out, or "
                "render the scene with translucent_path."
            )
    layouts = [(surface.points, surface.normals, surface.spacing) for surface in found.surfaces]
    return Precomputed(layouts, [surface.operator for surface in found.surfaces], keys(members))


def surfaces(scene: Any) -> list[tuple[Any, Any]]:
    """Return the translucent surfaces of a scene: pairs of `entry.Entry` and shape.

    Raises `ParameterError` where there are none, and for those that transport does not hold for.
    """
    media = Media.of(scene)
    for entry, choice, model in zip(
        media.entries, auto.choose("transport", media, scene), media.models, strict=True
    ):
        if model == WALK:
            raise ParameterError(
                f"transport does not hold for {entry.name!r}: {choice.reason}. Render the scene with "
                "translucent_path."
            )
    members = [(entry, shape) for entry in media.entries for shape in entry.shapes]
    if not members:
        raise ParameterError("the scene has no translucent object: give a shape the BSDF `translucent`.")
    return members


def keys(members: list[tuple[Any, Any]]) -> list[Key]:
    """Return what transport depends on, for each surface: the same in every process."""
    found = []
    for entry, shape in members:
        sigma_a, sigma_s = entry.mean_coefficients()
        digest = hashlib.sha256(shape.class_name().encode())
        if shape.is_mesh():
            for array in triangles(shape):
                digest.update(np.ascontiguousarray(array).tobytes())
        else:
            corners = [
                *np.ravel(shape.bbox().min),
                *np.ravel(shape.bbox().max),
                *np.ravel(shape.surface_area()),
            ]
            digest.update(",".join(f"{x:.5g}" for x in corners).encode())
        found.append(
            {
                "shape": digest.hexdigest(),
                "sigma_a": [float(f"{x:.5g}") for x in sigma_a],
                "sigma_s": [float(f"{x:.5g}") for x in sigma_s],
                "g": round(float(entry.g), 6),
                "eta": round(float(entry.eta), 6),
            }
        )
    return found


def load(path: str | os.PathLike) -> Precomputed:
    """Read what `Precomputed.save` has written; raises `ParameterError` for any other file, or a damaged one."""
    name = os.fspath(path)
    try:
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            if about["format"] != FORMAT:
                raise ParameterError(
                    f"{name!r} is of the format {about['format']!r}, not {FORMAT!r}: save it anew with this version."
                )
            arrays = {key: file[key] for key in file.files}
        layouts, operators = [], []
        for i in range(len(about["keys"])):
            layouts.append((arrays[f"{i}.points"], arrays[f"{i}.normals"], float(arrays[f"{i}.spacing"])))
            operators.append(_operator(arrays, f"{i}."))
    except FileNotFoundError as error:
        raise ParameterError(f"there is no file {name!r}: save transport there first.") from error
    except ParameterError:
        raise
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ParameterError(
            f"{name!r} holds no transport, or is damaged ({error}): save it anew."
        ) from error
    return Precomputed(layouts, operators, about["keys"])


def _matrices(operator: Pyramid) -> dict[str, list[Any]]:
    """Return the matrices of an operator by name; those of a list differ in their values alone."""
    found = {"smooth": [operator.smooth]} | {f"up{i}": [up] for i, up in enumerate(operator.ups)}
    for name, grids in (("mean", operator.means), ("moment", operator.moments)):
        found |= {f"{name}{grid}": kernels for grid, kernels in enumerate(grids) if kernels}
    return found


def _operator(arrays: dict[str, NDArray], prefix: str) -> Pyramid:
    """Return the operator that `_matrices` has named."""

    def matrices(name: str) -> list[Any] | None:
        name = f"{prefix}{name}."
        if f"{name}data" not in arrays:
            return None
        indices, indptr = arrays[f"{name}indices"], arrays[f"{name}indptr"]
        shape = tuple(arrays[f"{name}shape"])
        return [sparse.csr_matrix((data, indices, indptr), shape=shape) for data in arrays[f"{name}data"]]

    smooth, *ups = (matrices(name) or [None] for name in ("smooth", *(f"up{i}" for i in range(GRIDS - 1))))
    means, moments = ([matrices(f"{name}{i}") for i in range(GRIDS)] for name in ("mean", "moment"))
    facing = [arrays[f"{prefix}{name}"] for name in ("normals", *(f"facing{i}" for i in range(1, GRIDS)))]
    return Pyramid([up[0] for up in ups], facing, means, moments, smooth[0])
