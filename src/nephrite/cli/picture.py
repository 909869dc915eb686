"""Renders a scene under a progress bar, cleans the picture, and says in words how it came about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from nephrite.cli import progress
from nephrite.cli.errors import warn

if TYPE_CHECKING:
    import mitsuba as mi
    import numpy as np
    from numpy.typing import NDArray

    from nephrite.cli.job import Settings
    from nephrite.rendering.result import Result


def rendered(scene: mi.Scene, settings: Settings, title: str) -> Result:
    """Render `scene` as `settings` say, showing how far it is, and tell what `auto` chose."""
    import mitsuba as mi
    import numpy as np

    from nephrite.plugins import kept
    from nephrite.rendering import progressive

    described = settings.integrator()
    if settings.model == "transport" and settings.spp:  # the passes of a picture are parts of it
        pixels = int(np.prod(scene.sensors()[0].film().crop_size()))
        described["walks"] = kept.walks_for(pixels * settings.spp)
    integrator: Any = mi.load_dict(described)
    with progress.shown(title) as listen:
        result = progressive.render(
            scene,
            integrator,
            spp=settings.spp,
            time_s=settings.time,
            noise=settings.noise,
            on_progress=listen,
            seed=settings.seed,
        )
    for note in result.notes:
        warn(note)
    if settings.model == "auto":
        for choice in integrator.choices:
            typer.echo(f"{choice.name}: {choice.model}, {choice.reason}")
    return result


def denoised(scene: mi.Scene, result: Result) -> NDArray[np.float32] | None:
    """Return the picture without its noise, or None, with a warning, where the denoiser is missing."""
    from nephrite.image import denoise
    from nephrite.rendering import features

    reason = denoise.why_unavailable()
    if reason is not None:
        warn(reason)
        return None
    albedo, normal = features.albedo_normal(scene)
    return denoise.denoise(result.pixels, albedo, normal)


def to_denoise(paths: Sequence[Path], wanted: bool | None) -> list[Path]:
    """Return which of the files show a denoised picture: as `wanted`, or else PNG, for looking at, alone.

    EXR files are for measuring: there the noise is honest and a denoiser's guesses are not.
    """
    return [path for path in paths if (path.suffix.lower() == ".png" if wanted is None else wanted)]


def notes(result: Result) -> Mapping[str, str]:
    """Return how the picture came about, for its file."""
    return {
        "samples": str(result.spp),
        "noise_reached": f"{result.noise:.4g}",
        "seconds": f"{result.seconds:.1f}",
        "stopped_by": result.stopped,
    }


def summary(result: Result) -> str:
    """Return one line about a result: samples, noise and time."""
    noise = f", noise {result.noise:.2%}" if result.passes > 1 else ""
    return f"{result.spp} spp{noise} in {result.seconds:.1f} s"
