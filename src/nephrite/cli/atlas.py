"""`nephrite atlas`: measure every model against the truth, and write the page that says how wrong each is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from nephrite.cli import options
from nephrite.cli.compare import split
from nephrite.cli.errors import INTERRUPTED, complain, warn
from nephrite.errors import ParameterError

Page = Annotated[
    Path, typer.Option("--output", "-o", help="A Markdown file; figures go beside it.", metavar="FILE")
]
Quick = Annotated[
    bool, typer.Option("--quick", help="A small part in under a minute, for continuous integration.")
]
Models = Annotated[str, typer.Option(help="Models of `nephrite.profiles`, or all.", metavar="LIST")]
Work = Annotated[
    Path | None,
    typer.Option(help="Where results are kept; the cache folder if not given.", metavar="FOLDER"),
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Measure everything again, whatever has been kept.")]


def atlas(
    quick: Quick = False,
    output: Page = Path("atlas.md"),
    models: Models = "all",
    time: options.Time = None,
    work: Work = None,
    fresh: Fresh = False,
    variant: options.Variant = None,
) -> None:
    """Measure how wrong each model is, and where: half-spaces, slabs and pictures, on one page.

    The whole takes more than an hour on two cores. Each result is kept, so that a run that was stopped, by
    Ctrl-C or by --time, goes on where it ended. Results are known by version and parameters, pictures but the
    truth's also by the code that renders them; after other changes to the code use --fresh.
    """
    from nephrite.atlas import figures, measure, page
    from nephrite.atlas.pictures import views_of
    from nephrite.atlas.plan import FULL, QUICK
    from nephrite.atlas.store import Store
    from nephrite.cli import job
    from nephrite.cli import variant as variants
    from nephrite.image import write
    from nephrite.profiles.models import MODELS, find
    from nephrite.scene import cache
    from nephrite.scene.ply import write_atomically

    clock = job.Clock()
    plan = QUICK if quick else FULL
    names = tuple(find(name).name for name in (MODELS if models == "all" else split(models)))
    if not names:
        raise ParameterError(f"--models names no model: give some of {', '.join(MODELS)}, or all")
    if created := write.check_writable(output, (".md",)):
        warn(created)
    chosen = variants.choose(variant)
    folder = work or cache.folder() / "atlas"
    try:
        with clock.step("measuring"), _told() as on_cell:
            store = Store(folder, time or math.inf, on_cell, fresh)
            found = measure.measured(plan, store, names)
    except KeyboardInterrupt:
        complain(f"Stopped: no page was written. Results are kept in {folder}; the same command goes on.")
        raise typer.Exit(INTERRUPTED) from None
    place = output.parent / "figures" / output.stem
    shown = [view for view in plan.shown if view in views_of(found["pictures"])]
    with clock.step("figures"):
        for view in shown:
            figures.draw(plan, store, view, found["methods"], found["pictures"], place)
    data = measure.save(found, place / "atlas.json")
    made = page.Made(
        command="nephrite atlas" + (" --quick" if quick else ""),
        variant=chosen,
        minutes=store.seconds / 60.0,
        data=data.relative_to(output.parent).as_posix(),
        figures=place.relative_to(output.parent).as_posix(),
        shown=shown,
    )
    write_atomically(output, page.text(found, plan, made).encode())
    missing = len(plan.views) - len(views_of(found["pictures"]))
    if missing:
        typer.echo(f"{missing} of {len(plan.views)} views are missing: run the same command again to go on.")
    typer.echo(f"wrote {output.absolute()}, {data.name} and {len(shown)} figures in {place}\n{clock}")


@contextmanager
def _told() -> Iterator[Callable[[str], None]]:
    """Show what is being measured, on a terminal; yield what to call with it."""
    from rich.console import Console

    with Console(stderr=True).status("Looking for earlier results ...") as status:
        yield lambda label: status.update(f"Measuring: {label}")
