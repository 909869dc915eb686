"""A material: a medium with a name and a provenance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from nephrite.errors import ParameterError, unknown_name
from nephrite.physics.medium import RGB, Medium, rgb

__all__ = ["Kind", "Material", "key"]

Kind = Literal["measured", "artistic"]


def key(name: str) -> str:
    """Reduce a name to what tells it apart: `White Jade`, `white-jade` and `whitejade` are one material."""
    return "".join(c for c in name.casefold().replace("&", "and") if c.isalnum())


@dataclass(frozen=True)
class Material:
    """A named medium.

    | field      | meaning
    |
    | ---------- | ------------------------------------------------------------------------------------------
    |
    | `name`     | looked up regardless of case, spaces, dashes and underscores
    |
    | `medium`   | its coefficients, always in 1/mm
    |
    | `unit`     | the unit in which its source gives them
    |
    | `source`   | who measured or chose them
    |
    | `kind`     | `measured` or `artistic`
    |
    | `note`     | what to know: how it was chosen, how far to trust it
    |
    | `emission` | radiance emitted per length (RGB, per mm), the Q of the radiative transfer equation
    |

    Raises `ParameterError` for an empty name, an unknown kind or a negative or infinite emission.
    """

    name: str
    medium: Medium
    unit: str = "1/mm"
    source: str = "user"
    kind: Kind = "artistic"
    note: str = ""
    emission: RGB = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check what the medium has not checked."""
        if not isinstance(self.name, str) or not key(self.name):
            raise ParameterError(
                f"name is {self.name!r}: a material needs a name with a letter or a digit in it."
            )
        if self.kind not in get_args(Kind):
            raise unknown_name("kind of material", str(self.kind), get_args(Kind))
        object.__setattr__(self, "emission", rgb(self.emission, "emission"))
