"""`nephrite profile`: the models of a material against a simulation of it, as a plot and as numbers."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nephrite.cli import options
from nephrite.cli.compare import split
from nephrite.cli.errors import warn
from nephrite.errors import ParameterError

if TYPE_CHECKING:
    from nephrite.image.plot import Panel
    from nephrite.physics import Medium
    from nephrite.profiles.accuracy import Comparison, Truth

DEFAULT_MODELS = "dipole,better_dipole,photon_beam,normalized,tabulated"
DEFAULT_PHOTONS = 3_000_000
CHANNELS = ("red", "green", "blue")

Name = Annotated[str, typer.Argument(metavar="MATERIAL", help="A name from `nephrite materials`.")]
Models = Annotated[str, typer.Option(help="Models of `nephrite.profiles`, or all.", metavar="LIST")]
Plot = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", help="A PNG or SVG file; MATERIAL-profile.png if not given.", metavar="FILE"
    ),
]
Table = Annotated[
    Path | None, typer.Option("--csv", help="Write the numbers to a CSV file as well.", metavar="FILE")
]
Photons = Annotated[
    int | None,
    typer.Option(
        min=1000, help="Simulate so many; three million if not given, fewer if g is not 0.", metavar="N"
    ),
]


def profile(
    material: Name,
    models: Models = DEFAULT_MODELS,
    output: Plot = None,
    table: Table = None,
    photons: Photons = None,
    profile: options.Profile = None,
    material_file: options.MaterialFile = None,
    seed: options.Seed = 0,
) -> None:
    """Plot how far from its entry light leaves a material: models against a simulation, with their errors.

    Light enters diffusely, as in renders, and what is compared is all of it that has scattered. A model of
    multiple scattering is given the simulated single scattering. Errors are of all that leaves (total), and
    of its distribution (profile: L1 distance).
    """
    from rich.console import Console

    from nephrite import materials
    from nephrite.cli import job
    from nephrite.image import plot, write
    from nephrite.profiles import accuracy, measured
    from nephrite.profiles.models import MODELS, find

    clock = job.Clock()
    job.register_materials(material_file)
    found = materials.find(material)
    chosen = [find(name) for name in (MODELS if models == "all" else split(models))]
    columns = measured.read(profile) if profile is not None else ()
    own = [measured.model(column) for column in (columns * 3)[:3]]
    most = plot.MOST_LINES - bool(own)
    if not 0 < len(chosen) <= most:
        raise ParameterError(
            f"--models names {len(chosen)} models: give 1 to {most}, such as {DEFAULT_MODELS}"
        )
    path = output or Path(f"{found.name.replace(' ', '-')}-profile.png")
    for file, suffixes in ((path, plot.SUFFIXES), (table, (".csv",))):
        if file is not None and (made := write.check_writable(file, suffixes)):
            warn(made)
    medium = found.medium
    count = photons or round(DEFAULT_PHOTONS * (1.0 - abs(medium.g)))

    console = Console(stderr=True)
    with clock.step("simulation"), console.status(f"Simulating {count:,} photons ..."):
        truths = accuracy.simulate(medium, count, seed)
    channels = distinct(medium, truths, len(columns) > 1)
    if not channels:
        raise ParameterError(
            f"{found.name} does not scatter: no light leaves it, and there is nothing to plot."
        )
    with clock.step("models"), console.status("Evaluating the models ..."):
        compared = {
            (i, model.name): accuracy.compare(model, medium, i, truth)
            for i, (truth, _) in channels.items()
            for model in [*chosen, *own[i : i + 1]]
        }
    panels = [panel(medium, i, label, truth, compared) for i, (truth, label) in channels.items()]
    subtitle = (
        f"η = {medium.eta:g}, g = {medium.g:g} · diffuse light, all that has scattered · "
        f"dots: simulation of {count:,} photons, ±1 standard error · lines: models"
    )
    figure = plot.profiles(panels, f"Where light leaves {found.name.replace('-', ' ')}", subtitle)
    notes = {
        "material": found.name,
        "models": ",".join(m.name for m in chosen),
        "photons": str(count),
        "seed": str(seed),
        **({"profile": str(profile)} if profile is not None else {}),
    }
    written = [plot.save(path, figure, notes)]
    if table is not None:
        written.append(write.save_bytes(table, numbers(channels, compared).encode()))
    typer.echo(report(channels, compared))
    typer.echo("".join(f"wrote {file}\n" for file in written) + str(clock))


def distinct(medium: Medium, truths: list[Truth | None], apart: bool) -> dict[int, tuple[Truth, str]]:
    """Return the channels that scatter, by number, with their labels; equal ones once, unless all are to stay apart."""
    groups: dict[tuple[float, ...], list[int]] = {}
    for i in range(3):
        groups.setdefault((medium.sigma_a[i], medium.sigma_s[i], i if apart else 0), []).append(i)
    found = {}
    for members in groups.values():
        truth = truths[members[0]]
        label = "all channels" if len(members) == 3 else " and ".join(CHANNELS[i] for i in members)
        if truth is None:
            warn(f"{label}: does not scatter, no light leaves.")
        else:
            found[members[0]] = (truth, label)
    return found


def panel(
    medium: Medium, channel: int, label: str, truth: Truth, compared: dict[tuple[int, str], Comparison]
) -> Panel:
    """Put what is known of a channel into the form in which it is plotted."""
    from nephrite.image import plot

    inner, outer, area = truth.edges[1:-2], truth.edges[2:-1], truth.area[1:-1]
    within = truth.light.cumsum() / truth.light.sum()
    mfp = 1.0 / medium.sigma_t_prime[channel]
    lines = [
        plot.Line(
            name.replace("_", " "),
            one.light[1:-1] / area,
            percent(one.total_error),
            percent(one.profile_error, ""),
        )
        for (i, name), one in compared.items()
        if i == channel
    ]
    return plot.Panel(
        heading=label,
        note=f"albedo′ {medium.albedo_prime[channel]:.4g}, {100 * truth.total:.1f} % leaves",
        radius=(inner * outer) ** 0.5,
        truth=truth.light[1:-1] / area,
        error=truth.error[1:-1] / area,
        lines=lines,
        mark=(mfp, f"1/σₜ′ = {mfp:.3g} mm"),
        span=(float(truth.edges[(within < 0.01).sum()]), float(truth.edges[(within < 0.9995).sum() + 1])),
    )


def numbers(channels: dict[int, tuple[Truth, str]], compared: dict[tuple[int, str], Comparison]) -> str:
    """Return the table of the rings: R(r) in 1/mm^2 of the simulation and of each model, as CSV."""
    models = list(dict.fromkeys(name for _, name in compared))
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["channel", "r_from_mm", "r_to_mm", "simulation_per_mm2", "standard_error", *models])
    for i, (truth, label) in channels.items():
        columns = [truth.light, truth.error, *(compared[i, name].light for name in models)]
        for k in range(len(truth.light) - 1):  # the last ring has no outer edge
            if truth.error[k] < truth.light[k]:
                values = (column[k] / truth.area[k] for column in columns)
                writer.writerow(
                    [
                        label,
                        *(f"{edge:.6g}" for edge in truth.edges[k : k + 2]),
                        *(f"{v:.6g}" for v in values),
                    ]
                )
    return stream.getvalue()


def report(channels: dict[int, tuple[Truth, str]], compared: dict[tuple[int, str], Comparison]) -> str:
    """Return the errors as text, one line for each channel and model."""
    lines = []
    for i, (truth, label) in channels.items():
        lines.append(
            f"{label}: {100 * truth.total:.2f} +- {100 * truth.total_error:.2f} % of the light that enters leaves "
            f"(noise of profile errors: {100 * truth.noise:.1f} %)"
        )
        lines += [
            f"  {name:14} total {percent(one.total_error):>8}   profile {percent(one.profile_error, ''):>7}"
            for (j, name), one in compared.items()
            if j == i
        ]
    return "\n".join(lines)


def percent(fraction: float, sign: str = "+") -> str:
    """Return a fraction as percent, with as many digits as matter."""
    digits = 0 if abs(fraction) >= 0.2 else 1
    value = round(100.0 * fraction, digits) + 0.0  # no -0.0
    return f"{value:{sign}.{digits}f} %".replace("-", "−")
