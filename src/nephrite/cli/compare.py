"""`nephrite compare`: one object by several models, terms or materials, side by side, with differences."""

from __future__ import annotations

from pathlib import Path

import typer

from nephrite.cli import options
from nephrite.cli.errors import INTERRUPTED, complain, warn
from nephrite.errors import ParameterError


def compare(
    source: options.Source = "dragon",
    models: options.Models = None,
    terms: options.TermsList = None,
    materials: options.Materials = None,
    reference: options.Reference = "last",
    material: options.Material = None,
    size: options.Size = None,
    model: options.Model = None,
    profile: options.Profile = None,
    thickness: options.Thickness = None,
    light: options.Light = None,
    spp: options.Spp = None,
    time: options.Time = None,
    noise: options.Noise = None,
    resolution: options.Resolution = None,
    output: options.Figure = None,
    exit: options.Exit = None,
    alpha: options.Alpha = None,
    material_file: options.MaterialFile = None,
    up: options.Up = None,
    exposure: options.Exposure = 0.0,
    denoise: options.Denoise = None,
    seed: options.Seed = 0,
    variant: options.Variant = None,
) -> None:
    """Render an object in several ways, side by side, with maps and numbers of the differences.

    Lists are separated by commas or by |. With several lists every combination is shown. Limits (--spp,
    --time, --noise) hold for each picture. The numbers are those of the pictures as rendered; the ones shown
    are denoised.
    """
    from nephrite.cli import job, panels
    from nephrite.cli import variant as variants
    from nephrite.image import write

    clock = job.Clock()
    own = job.register_materials(material_file)
    lists = {"model": models, "terms": terms, "material": materials}
    values = {name: split(text) for name, text in lists.items() if text is not None}
    base = job.Settings.given(
        source, material=material or own, size=size, light=light, alpha=alpha, up=up, model=model, exit=exit,
        resolution=resolution, spp=spp, time=time, noise=noise, seed=seed,
        profile=profile, thickness=thickness,
    )  # fmt: skip
    settings = {label: one.checked() for label, one in panels.variations(base, values).items()}
    if len(settings) < 2:
        raise ParameterError(
            "nothing to compare: name at least two with --models, --terms or --materials, "
            "such as --models brdf,dipole,walk"
        )
    path = output or Path(f"{Path(source).stem}-comparison.png")
    if path.suffix.lower() != ".png":
        raise ParameterError(f"{str(path)!r}: a labelled figure is a PNG file; name one that ends in .png")
    if made := write.check_writable(path):
        warn(made)

    with clock.step("start"):
        variants.choose(variant)
    with clock.step("object"):
        subject = job.Subject(source)
    shown: list[panels.Panel] = []
    for label, setting in settings.items():
        with clock.step(label):
            shown.append(panels.rendered(subject, setting, label, denoise is not False))
        if shown[-1].result.interrupted:
            complain("Stopped: no figure was written.")
            raise typer.Exit(INTERRUPTED)
    against = shown[0 if reference == "first" else -1]
    title = Path(source).stem if "material" in values else next(iter(settings.values())).title()
    notes = {**base.notes(), "compared": " | ".join(settings), "reference": against.label}
    write.save(path, panels.laid_out(shown, against, title, exposure), notes)
    for panel, difference in zip(shown, panels.differences(shown, against), strict=True):
        told = "the reference" if panel is against else str(difference)
        typer.echo(f"{panel.label}: {told}")
    typer.echo(f"wrote {path.absolute()}\n{clock}")


def split(text: str) -> list[str]:
    """Return the entries of a list that is separated by commas or vertical bars, each once."""
    entries = (entry.strip() for entry in text.replace("|", ",").split(","))
    return list(dict.fromkeys(entry for entry in entries if entry))
