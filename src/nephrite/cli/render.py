"""`nephrite render`: one picture of one object or scene."""

from __future__ import annotations

from pathlib import Path

import typer

from nephrite.cli import options
from nephrite.cli.errors import INTERRUPTED, warn


def render(
    source: options.Source = "dragon",
    material: options.Material = None,
    size: options.Size = None,
    model: options.Model = None,
    profile: options.Profile = None,
    thickness: options.Thickness = None,
    terms: options.Terms = None,
    light: options.Light = None,
    spp: options.Spp = None,
    time: options.Time = None,
    noise: options.Noise = None,
    resolution: options.Resolution = None,
    output: options.Outputs = None,
    exit: options.Exit = None,
    alpha: options.Alpha = None,
    material_file: options.MaterialFile = None,
    up: options.Up = None,
    exposure: options.Exposure = 0.0,
    denoise: options.Denoise = None,
    seed: options.Seed = 0,
    variant: options.Variant = None,
) -> None:
    """Render an object in a material, or a Mitsuba scene.

    A picture is finished when it has --spp samples, when --time is over, or when --noise is reached,
    whichever comes first. Ctrl-C ends it early and keeps the picture so far.
    """
    from nephrite.cli import job, picture
    from nephrite.cli import variant as variants
    from nephrite.image import write

    clock = job.Clock()
    own = job.register_materials(material_file)
    settings = job.Settings.given(
        source, material=material or own, size=size, light=light, alpha=alpha, up=up, model=model,
        terms=terms, exit=exit, resolution=resolution, spp=spp, time=time, noise=noise, seed=seed,
        profile=profile, thickness=thickness,
    ).checked()  # fmt: skip
    paths = output or [Path(settings.title().replace(" in ", "-").replace(" ", "-") + ".png")]
    for path in paths:
        made = write.check_writable(path)
        if made:
            warn(made)

    with clock.step("start"):
        variants.choose(variant)
    with clock.step("object"):
        subject = job.Subject(source)
    with clock.step("scene"):
        scene = subject.scene(settings)
    with clock.step("render"):
        result = picture.rendered(scene, settings, settings.title())
    clean, smooth = None, picture.to_denoise(paths, denoise)
    if smooth:
        with clock.step("denoise"):
            clean = picture.denoised(scene, result)
    notes = {**settings.notes(), **picture.notes(result)}
    with clock.step("write"):
        for path in paths:
            pixels = clean if path in smooth else None
            told = {**notes, "denoised": "no" if pixels is None else "yes", "exposure": f"{exposure:g}"}
            write.save(path, result.pixels if pixels is None else pixels, told, exposure=exposure)
    for path in paths:
        typer.echo(f"wrote {path.absolute()}")
    typer.echo(f"{picture.summary(result)}; {clock}")
    if result.interrupted:
        warn("stopped early: this is the picture so far.")
        raise typer.Exit(INTERRUPTED)
