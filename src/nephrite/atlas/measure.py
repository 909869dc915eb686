"""Everything that the atlas measures, in one dictionary that JSON can hold."""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nephrite import __version__
from nephrite.atlas import choice, pictures, planes
from nephrite.atlas.plan import Plan
from nephrite.atlas.store import NotYetError, Store
from nephrite.scene.ply import write_atomically

__all__ = ["measured", "save"]

_DIGITS = 4


def measured(plan: Plan, store: Store, models: tuple[str, ...]) -> dict[str, Any]:
    """Measure what the plan asks for; a variant must be set.

    Returns `version`, `date`, `methods`, rows of `half_spaces` (`planes.HalfSpace`), `slabs` (`planes.Slab`),
    `pictures` (`pictures.Picture`) and `contests` (`contest.Contest`), and what follows from them: `advice` and `rules`
    (`choice`). What there was no time for is left out.
    """
    found: dict[str, Any] = {
        "version": __version__,
        "date": datetime.date.today().isoformat(),
        "methods": list(pictures.methods(models)) if plan.views else [],
    }
    for name, part in (("half_spaces", planes.half_spaces), ("slabs", planes.slabs)):
        try:
            found[name] = part(plan, store, models)
        except NotYetError:
            found[name] = []
    rows, found["contests"] = pictures.pictures(plan, store, tuple(found["methods"]))
    found["pictures"] = rows
    limits = (choice.FINAL, choice.PREVIEW) if plan.timed else ()
    found["advice"] = choice.advice(rows) if plan.timed else []
    found["rules"] = [one for limit in limits if (one := choice.rule(rows, limit))]
    return found


def save(found: Mapping[str, Any], path: Path) -> Path:
    """Write the measurements as JSON with four digits, in one step; what is no number is null."""
    lines = []
    for key, value in found.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n".join(json.dumps(_rounded(row), ensure_ascii=False) for row in value)
            lines.append(f"{json.dumps(key)}: [\n{rows}\n]")
        else:
            lines.append(f"{json.dumps(key)}: {json.dumps(_rounded(value), ensure_ascii=False)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, ("{\n" + ",\n".join(lines) + "\n}\n").encode())
    return path


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_rounded(one) for one in value]
    return value
