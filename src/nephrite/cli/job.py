"""What `render` and `compare` have in common: the settings of a picture, its subject, and making it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nephrite.cli.errors import warn
from nephrite.errors import ParameterError

if TYPE_CHECKING:
    import mitsuba as mi

    from nephrite.scene.triangles import TriangleMesh


DEFAULT_RESOLUTION = (800, 600)
DEFAULT_SPP = 64
OF_AN_OBJECT = ("material", "size", "light", "alpha", "up")  # settings that a scene file has itself


@dataclass(frozen=True)
class Settings:
    """Everything that decides how a picture looks; written into its file.

    Lengths are in millimetres, times in seconds, `noise` is a fraction. Of the limits `spp`, `time` and
    `noise` the first one reached ends the render; None leaves one out. `profile` and `thickness` belong to
    the models measured and multipole.
    """

    source: str
    material: str = "jade"
    size: float = 100.0
    light: str = "studio"
    alpha: float = 0.0
    up: str = "y"
    model: str = "walk"
    terms: str = "all"
    exit: str = "lobe"
    resolution: tuple[int, int] | None = None
    spp: int | None = None
    time: float | None = None
    noise: float | None = None
    seed: int = 0
    profile: Path | None = None
    thickness: float | None = None

    @classmethod
    def given(cls, source: str, **values: Any) -> Settings:
        """Return the settings for `source` with those `values` that aren't None, and sensible limits.

        Raises ParameterError if a scene file is given something that only an object can have.
        """
        chosen = {name: value for name, value in values.items() if value is not None}
        surplus = [f"--{name}" for name in OF_AN_OBJECT if name in chosen]
        if is_scene_file(source) and surplus:
            raise ParameterError(
                f"{', '.join(surplus)} can't be combined with the scene file {source!r}, which has its own: "
                "change it there, or render a mesh"
            )
        if not any(name in chosen for name in ("spp", "time", "noise")):
            chosen["spp"] = DEFAULT_SPP
        return cls(source, **chosen)

    def integrator(self) -> dict[str, Any]:
        """Return the integrator that these settings ask for."""
        from nephrite.scene import build

        return build.integrator_dict(**self.method())

    def method(self) -> dict[str, Any]:
        """Return the parameters of `scene.build.integrator_dict`."""
        names = ("model", "terms", "exit", "profile", "thickness")
        return {name: getattr(self, name) for name in names}

    def apart_from(self, models: set[str]) -> Settings:
        """Return the settings without what belongs to another of these models."""
        from nephrite.plugins.settings import DETAILS

        others = {name: None for name, owner in DETAILS.items() if owner in models - {self.model}}
        return replace(self, **others)

    def checked(self) -> Settings:
        """Return the settings with the material's own name; ParameterError, with a suggestion, if unknown.

        Models, terms and exits are checked as well.
        """
        from nephrite import materials

        self.integrator()
        return replace(self, material=materials.find(self.material).name)

    def title(self) -> str:
        """Return what is shown, in a few words."""
        name = Path(self.source).stem
        return name if is_scene_file(self.source) else f"{name} in {self.material}"

    def notes(self) -> dict[str, str]:
        """Return the settings as text, for the picture's file."""
        import mitsuba as mi

        dropped = OF_AN_OBJECT if is_scene_file(self.source) else ()
        values: dict[str, Any] = {**asdict(self), "size": f"{self.size:g}mm"}
        if self.thickness is not None:
            values["thickness"] = f"{self.thickness:g}mm"
        if self.resolution is not None:
            values["resolution"] = "{}x{}".format(*self.resolution)
        notes = {
            name: str(value) for name, value in values.items() if value is not None and name not in dropped
        }
        return {**notes, "variant": str(mi.variant()), "mitsuba": str(mi.__version__)}


def is_scene_file(source: str) -> bool:
    """Return whether `source` names a Mitsuba scene, as opposed to a mesh or a built-in object."""
    return source.lower().endswith(".xml")


class Subject:
    """The object or the scene that a command was given, read once and rendered as often as needed."""

    def __init__(self, source: str) -> None:
        """Find out what `source` names; raises ParameterError or MeshError if it is nothing readable."""
        from nephrite.scene import meshes, named

        self.scene_file: Path | None = None
        self.mesh: TriangleMesh | None = None
        if is_scene_file(source):
            self.scene_file = Path(source)
        elif Path(source).suffix or len(Path(source).parts) > 1:
            self.mesh = meshes.load(source)
        else:
            self.mesh = named.find(source)
        if self.mesh is not None:
            for note in (self.mesh.note, *self.mesh.report.warnings):
                if note:
                    warn(note)

    def scene(self, settings: Settings) -> mi.Scene:
        """Load the scene; for a scene file, its own materials, lights and camera."""
        import mitsuba as mi

        from nephrite.scene import build

        if self.scene_file is not None:
            return build.load_xml(self.scene_file, settings.resolution)
        assert self.mesh is not None
        scene = mi.load_dict(
            build.scene_dict(
                self.mesh,
                settings.material,
                settings.size,
                light=settings.light,
                resolution=settings.resolution or DEFAULT_RESOLUTION,
                alpha=settings.alpha,
                up=settings.up,
                **settings.method(),
            ),
            **build.LOADING,
        )
        assert isinstance(scene, mi.Scene)
        return scene


class Clock:
    """How long each step of a command took."""

    def __init__(self) -> None:
        """Start the clock."""
        self.start = time.perf_counter()
        self.seconds: dict[str, float] = {}

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Time what happens inside, as the step `name`."""
        start = time.perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def __str__(self) -> str:
        """Return all steps with their seconds, and the total."""
        total = time.perf_counter() - self.start
        return (
            ", ".join(f"{name} {took:.1f} s" for name, took in self.seconds.items())
            + f"; {total:.1f} s in all"
        )


def register_materials(path: Path | None) -> str | None:
    """Make the materials of the TOML file at `path` known by name; return its name if it is only one."""
    if path is None:
        return None
    from nephrite import materials

    found = materials.load_toml(path)
    for material in found.values():
        materials.register(material)
    return next(iter(found)) if len(found) == 1 else None
