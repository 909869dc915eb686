"""Writes PNG and EXR files that tell how they were made, and others; never leaves half a file behind."""

from __future__ import annotations

import contextlib
import io
import os
import stat
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError
from PIL.PngImagePlugin import PngInfo

from nephrite.errors import ParameterError
from nephrite.image.tonemap import to_srgb8

SUFFIXES = (".exr", ".png")
PREFIX = "nephrite:"
"""Stands before each key in the file, so that no key can collide with a format's own attributes."""

MAX_KEY = 79 - len(PREFIX)
"""Longest key, from the 79 characters that PNG grants a keyword."""


def save(
    path: str | os.PathLike,
    pixels: NDArray,
    metadata: Mapping[str, str] | None = None,
    *,
    exposure: float = 0.0,
    shoulder: bool = False,
) -> Path:
    """Write a picture as PNG (sRGB, 8 bit) or EXR (linear, 32 bit float), by the suffix of `path`.

    The file is made in memory, written beside its destination and moved into place, so that a picture that
    was there before survives any failure.

    Args:
        path: Where to; a last folder that is missing is made (`check_writable`).
        pixels: (height, width, 3) linear light, or uint8 sRGB (a figure; PNG only).
        metadata: Settings to keep in the file; `read_metadata` returns them. Nephrite's version is added.
        exposure: Stops, for PNG only; EXR files hold the light itself.
        shoulder: For PNG only; see `tonemap.to_srgb8`.

    Returns:
        The path of the file that was written.

    Raises:
        ParameterError: The path cannot be written, or pixels or metadata are not of the form above.
    """
    check_writable(path)
    target = _resolve(path)
    pixels = np.asarray(pixels)
    if pixels.ndim != 3 or pixels.shape[2] != 3 or 0 in pixels.shape:
        raise ParameterError(f"a picture must have the shape (height, width, 3), not {pixels.shape}.")
    notes = _checked(metadata or {})
    if target.suffix.lower() == ".png":
        screen = pixels if pixels.dtype == np.uint8 else to_srgb8(pixels, exposure, shoulder)
        content = _encode_png(screen, notes)
    elif pixels.dtype == np.uint8:
        raise ParameterError(f"{target.name}: a figure of 8 bits is not linear light; write it as PNG.")
    else:
        content = _encode_exr(pixels.astype(np.float32), notes)
    _replace(target, content)
    return target


def save_bytes(path: str | os.PathLike, content: bytes) -> Path:
    """Write what is no picture (an SVG plot, a table) in one step, as `save` does; returns the file's path.

    Raises:
        ParameterError: The path cannot be written.
    """
    target = _resolve(path)
    check_writable(target, (target.suffix.lower(),))
    _replace(target, content)
    return target


def check_writable(path: str | os.PathLike, suffixes: Sequence[str] = SUFFIXES) -> str | None:
    """Make sure, before a long render, that `save` will be able to write to `path`.

    If only the last folder is missing, it is made; deeper ones are not, for they are likely a typing error.

    Args:
        path: Where to.
        suffixes: What its name may end in.

    Returns:
        A message when the folder had to be made, else None.

    Raises:
        ParameterError: With the reason and the remedy.
    """
    target = _resolve(path)
    if target.suffix.lower() not in suffixes:
        raise ParameterError(
            f"cannot write {os.fspath(path)!r}: the name must end in {' or '.join(suffixes)}, "
            f"not {target.suffix!r}."
        )
    try:
        return _make_folder(target.parent) if not target.parent.exists() else _try_out(target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ParameterError(f"cannot write {str(target)!r}: {reason}. Choose another folder.") from error


def read_metadata(path: str | os.PathLike) -> dict[str, str]:
    """Read back the settings that `save` put into a PNG or EXR file; `version` is Nephrite's.

    Returns:
        The settings; empty if another program wrote the file.

    Raises:
        ParameterError: The file is missing or is not a picture of these kinds.
    """
    source = _resolve(path)
    try:
        found = _read_png(source) if source.suffix.lower() == ".png" else _read_exr(source)
    except (OSError, RuntimeError, UnidentifiedImageError, SyntaxError) as error:
        raise ParameterError(f"cannot read {str(source)!r} as a picture: {error}") from error
    return {key.removeprefix(PREFIX): value for key, value in found.items() if key.startswith(PREFIX)}


def _resolve(path: str | os.PathLike) -> Path:
    """Follow links, so that a link's target is replaced and not the link."""
    return Path(os.path.realpath(Path(path).expanduser()))


def _checked(metadata: Mapping[str, str]) -> dict[str, str]:
    from nephrite import __version__

    for key, value in metadata.items():
        if not (isinstance(key, str) and 0 < len(key) <= MAX_KEY and key.isascii() and key.isprintable()):
            raise ParameterError(f"metadata key {key!r}: use 1 to {MAX_KEY} printable ASCII characters.")
        if not isinstance(value, str) or "\0" in value:
            raise ParameterError(f"metadata {key!r} must be text without NUL characters, not {value!r}.")
    return {PREFIX + key: value for key, value in {**metadata, "version": __version__}.items()}


def _encode_png(pixels: NDArray[np.uint8], notes: Mapping[str, str]) -> bytes:
    info = PngInfo()
    for key, value in notes.items():
        if value.isascii():
            info.add_text(key, value)
        else:
            info.add_itxt(key, value)
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(stream, "PNG", pnginfo=info)
    return stream.getvalue()


def _read_png(path: Path) -> dict[str, str]:
    with Image.open(path, formats=["PNG"]) as image:
        image.load()
        return {key: str(value) for key, value in image.info.items() if isinstance(key, str)}


def _encode_exr(pixels: NDArray[np.float32], notes: Mapping[str, str]) -> bytes:
    import mitsuba as mi

    bitmap = mi.Bitmap(np.ascontiguousarray(pixels))
    attributes = bitmap.metadata()
    for key, value in notes.items():
        attributes[key] = value
    stream = mi.MemoryStream()
    bitmap.write(stream, mi.Bitmap.FileFormat.OpenEXR)
    return stream.raw_buffer()


def _read_exr(path: Path) -> dict[str, str]:
    import mitsuba as mi

    attributes = mi.Bitmap(str(path)).metadata()
    return {key: str(attributes[key]) for key in attributes.keys()}  # noqa: SIM118 (not a mapping)


def _make_folder(folder: Path) -> str:
    if not folder.parent.is_dir():
        raise ParameterError(
            f"cannot write into {str(folder)!r}: {str(folder.parent)!r} is not a folder either. "
            "Make the folders first, or correct the path."
        )
    folder.mkdir()
    return f"made the folder {folder}"


def _try_out(target: Path) -> None:
    """Raise unless a file can be made beside `target` and `target` may be replaced."""
    if not target.parent.is_dir():
        raise ParameterError(f"cannot write {str(target)!r}: {str(target.parent)!r} is a file, not a folder.")
    if target.exists():
        mode = target.stat().st_mode
        if stat.S_ISDIR(mode):
            raise ParameterError(f"cannot write {str(target)!r}: it is a folder. Give the name of a file.")
        if not stat.S_ISREG(mode):
            raise ParameterError(f"cannot write {str(target)!r}: it is not an ordinary file.")
        if not mode & 0o222 or not os.access(target, os.W_OK):
            raise ParameterError(
                f"cannot write {str(target)!r}: the file is read-only. Choose another name, or allow writing."
            )
    probe = _beside(target)
    os.close(os.open(probe, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    probe.unlink()


def _beside(target: Path) -> Path:
    return target.with_name(f".nephrite-{uuid.uuid4().hex[:12]}.tmp")


def _replace(target: Path, content: bytes) -> None:
    """Put `content` in place of `target` in one step that either happens or does not."""
    temporary = _beside(target)
    try:
        with open(temporary, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            temporary.chmod(stat.S_IMODE(target.stat().st_mode))
        os.replace(temporary, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ParameterError(f"writing {str(target)!r} failed: {reason}; nothing was changed.") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
