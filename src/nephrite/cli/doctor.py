"""`nephrite doctor`: what this machine has, and what to do about what is missing."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from typing import Literal

import typer

from nephrite import __version__, llvm
from nephrite.cli.errors import FAILED

PROBE_SECONDS = 120
_PROBE = """
import json, sys
import nephrite.cli.variant as variant, drjit as dr
problem = variant.trouble(sys.argv[1])
version = getattr(dr.detail, sys.argv[1][:4] + "_version")()
print(json.dumps([problem, ".".join(map(str, version))]))
"""


@dataclass(frozen=True)
class Finding:
    """One line of the report: what was looked at, how it is, and what to do if it isn't well."""

    what: str
    state: Literal["ok", "missing", "broken"]
    detail: str
    remedy: str = ""


def doctor() -> None:
    """Tell what this machine has for rendering, and what to do about what is missing."""
    from rich.console import Console
    from rich.table import Table

    console = Console(soft_wrap=not sys.stdout.isatty())
    table = Table(box=None, show_header=False, padding=(0, 1))
    marks = {"ok": "[green]ok", "missing": "[yellow]--", "broken": "[red]no"}
    backends = {}
    with console.status("Looking around ..."):
        findings = [*software(), *(backends := probe_backends()).values(), *helpers(), *cached_meshes()]
    for finding in findings:
        table.add_row(marks[finding.state], finding.what, finding.detail)
        if finding.remedy:
            table.add_row("", "", f"[dim]-> {finding.remedy}")
    console.print(f"Nephrite {__version__} on {platform.platform()}")
    console.print(table)
    if not can_render(backends):
        console.print("[red]Nothing here can render: see above for what to do.")
        raise typer.Exit(FAILED)
    fastest = "CUDA" if backends["cuda"].state == "ok" else "LLVM"
    console.print(f"[green]Ready to render[/], on {fastest}: try `nephrite render pendant`.")


def can_render(backends: dict[str, Finding]) -> bool:
    """Return whether one of the `backends` works."""
    return any(finding.state == "ok" for finding in backends.values())


def software() -> Iterator[Finding]:
    """Yield what is said about Python, Mitsuba and Dr.Jit."""
    yield Finding("Python", "ok", f"{platform.python_version()} at {sys.executable}")
    for name, package in (("Mitsuba", "mitsuba"), ("Dr.Jit", "drjit")):
        try:
            yield Finding(name, "ok", metadata.version(package))
        except metadata.PackageNotFoundError:
            yield Finding(name, "broken", "not installed", f"pip install {package}")


def probe_backends() -> dict[str, Finding]:
    """Return what is said about LLVM and CUDA, by tracing a ray on each in a process of its own.

    Some LLVM versions abort the process, so this one must not try them.
    """
    from nephrite.cli.variant import LLVM_REMEDY

    library = os.environ.get(llvm.ENVIRONMENT_VARIABLE, "the system")
    missing_gpu = "only needed for speed: an NVIDIA GPU with a driver of version 535 or later"
    return {
        "llvm": _probe("LLVM", "llvm_ad_rgb", f"from {library}", "broken", LLVM_REMEDY),
        "cuda": _probe("CUDA", "cuda_ad_rgb", "and OptiX work", "missing", missing_gpu),
    }


def _probe(
    what: str, variant: str, praise: str, failed: Literal["missing", "broken"], remedy: str
) -> Finding:
    command = [sys.executable, "-c", _PROBE, variant]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=PROBE_SECONDS, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        return Finding(what, failed, f"no answer within {PROBE_SECONDS} s", remedy)
    try:
        problem, version = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        lines = [line for line in done.stderr.splitlines() if line.strip()] or ["no message"]
        problem, version = f"the process ended with code {done.returncode}: {lines[0][:160]}", ""
    if problem is not None:
        return Finding(what, failed, problem, remedy)
    return Finding(what, "ok", f"{version} {praise}")


def helpers() -> Iterator[Finding]:
    """Yield what is said about the programs and libraries that rendering can do without."""
    from nephrite.image import denoise

    if denoise.available():
        yield Finding("OIDN", "ok", f"pyoidn {metadata.version('pyoidn')}: pictures can be denoised")
    else:
        yield Finding("OIDN", "missing", "pictures stay as noisy as rendered", "pip install pyoidn")
    npm = shutil.which("npm")
    if npm:
        yield Finding("npm", "ok", npm)
    else:
        yield Finding(
            "npm",
            "missing",
            "the Stanford dragon can't be fetched; `pendant` and the other names are built in",
            "install Node.js (it brings npm), or render a mesh of your own",
        )


def cached_meshes() -> Iterator[Finding]:
    """Yield what is said about the meshes that were fetched before."""
    from nephrite.scene import cache

    folder = cache.folder()
    files = sorted(folder.glob("*.ply")) if folder.is_dir() else []
    if files:
        sizes = ", ".join(f"{file.name} ({file.stat().st_size / 1e6:.1f} MB)" for file in files)
        yield Finding("Meshes", "ok", f"{sizes} in {folder}")
    else:
        yield Finding(
            "Meshes", "missing", f"none yet in {folder}", "fetched when first used: `nephrite render dragon`"
        )
