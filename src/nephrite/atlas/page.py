"""The atlas as a page of the documentation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import fmean, median
from typing import Any

from nephrite.atlas import choice, contest, page_planes
from nephrite.atlas.compared import BLOCK, WORST_BLOCK
from nephrite.atlas.figures import file_name
from nephrite.atlas.pictures import views_of
from nephrite.atlas.plan import Plan, View
from nephrite.atlas.tables import interval, paragraph, percent, table, title
from nephrite.profiles.models import MODELS

__all__ = ["Made", "text"]

Row = dict[str, Any]


@dataclass(frozen=True)
class Made:
    """How a page came about: the command, Mitsuba's variant, minutes that all results took; where data and figures are.

    `data` and `figures` are paths relative to the page; `shown` the views that have a figure.
    """

    command: str
    variant: str
    minutes: float
    data: str
    figures: str
    shown: Sequence[View]


def text(found: dict[str, Any], plan: Plan, made: Made) -> str:
    """Return the page, in Markdown, for what `measure.measured` has found."""
    parts = [_head(found, made)]
    if found["advice"]:
        parts.append(_advice(found))
    if found["half_spaces"]:
        parts.append(page_planes.half_spaces(found["half_spaces"], plan))
    if found["slabs"]:
        parts.append(page_planes.slabs(found["slabs"], plan))
    if found["pictures"]:
        parts.append(_pictures(found, plan, made))
    return "\n\n".join(parts) + "\n"


def _head(found: dict[str, Any], made: Made) -> str:
    told = paragraph(
        f"How wrong each model is, and where. Version {found['version']}, {found['date']}, made by `{made.command}` in",
        f"`{made.variant}`; measuring took {made.minutes:.1f} minutes. All numbers are in",
        f"[one file]({made.data}).",
        "Errors do not depend on the machine; speeds are ratios to `walk` on the same machine. What is smaller than",
        "twice its standard error is given as `< limit`.",
    )
    note = f"<!-- Made by `{made.command}`: change the code in nephrite.atlas, not this page. -->"
    return f"# The accuracy atlas\n\n{note}\n\n{told}"


def _advice(found: dict[str, Any]) -> str:
    def told(one: Sequence[Any]) -> str:
        name, error, noise, speed = one
        return f"{title(name)} ({percent(error, noise)} %, {speed:.2g}×)"

    head = (
        "thickness", "albedo′", "least error", f"within {100 * choice.FINAL:g} %",
        f"within {100 * choice.PREVIEW:g} %", "best without walking", "n",
    )  # fmt: skip
    rows = [
        [
            interval(*a["thickness"]), interval(*a["albedo"], most=1.0), told(a["exact"]), told(a["final"]),
            told(a["preview"]), told(a["diffusion"]), str(a["count"]),
        ]
        for a in found["advice"]
    ]  # fmt: skip
    words = paragraph(
        "Thickness is the mean chord of the object, 4 V / S, in reduced mean free paths; albedo′ is reduced, too; both",
        "of a colour channel. In brackets: the error in the pictures below, and the efficiency relative to the walk",
        '(2× takes half the time to the same noise). "Within" is for final pictures and previews: the most efficient',
        "method whose error is within the limit, the walk if there is none. n: channels of pictures.",
    )
    return "\n\n".join(["## Which model should I use?", words, table(head, rows), _in_words(found)])


def _in_words(found: dict[str, Any]) -> str:
    rules = {rule["limit"]: rule for rule in found["rules"]}
    told = ["Rules for whole objects, such as `auto` needs, follow from the same pictures."]
    for limit in (choice.FINAL, choice.PREVIEW):
        told.append(f"Within {100 * limit:g} %:")
        rule = rules.get(limit)
        if rule is None:
            told.append(
                "walk; no other model that saves time stays within the limit in all pictures of objects beyond any "
                "thickness and albedo′ that was looked at."
            )
            continue
        told.append(
            f"`{rule['model']}` from a thickness of {rule['thickness']:.3g} and an albedo′ of {rule['albedo']:.3g}, in "
            f"the least channel, on; else walk. In the {rule['views']} pictures beyond, its error is "
            f"{percent(rule['worst'])} % at the most, its efficiency {rule['efficiency']:.2g} times the walk's."
        )
    return paragraph(*told)


def _pictures(found: dict[str, Any], plan: Plan, made: Made) -> str:
    rows, names = found["pictures"], found["methods"]
    views = views_of(rows)
    width, height = plan.resolution
    parts = [
        "## Pictures",
        paragraph(
            f"{len(views)} of {len(plan.views)} views of {width} x {height} pixels: one large light at the side or",
            "behind, no floor, no sky, and only light that has scattered inside (`single+multiple`): reflections are",
            "the same for all. The truth is `walk` with exact exits; `walk` in the tables has the lobe. *Error* is the",
            f"root mean square of the difference over blocks of {BLOCK} x {BLOCK} pixels and the colour channels,",
            "divided by the truth's, with the noise of both taken out: a perfect model has 0, a black picture 100 %.",
            f"*Worst block*: of {WORST_BLOCK} x {WORST_BLOCK} pixels, relative to its own light.",
            *(_of_speed(width * height * plan.spp // 2) if plan.timed else ()),
            *_twins(names),
        ),
        _overall(rows, names, plan.timed),
        "Error by object and size:",
        _errors(rows, names, lambda row: f"{row['object']}, {row['size']:g} mm"),
        "Error by material:",
        _errors(rows, names, lambda row: row["material"].replace("-", " ")),
        "Error by light:",
        _errors(rows, names, lambda row: row["light"]),
        *_contests(found["contests"], plan),
        "Error in every view, in percent, with standard errors:",
        _every(rows, names, views),
    ]
    shown = [view for view in made.shown if view in views]
    parts += [f"![{view}]({made.figures}/{file_name(view)})" for view in shown]
    if shown:
        parts.insert(
            len(parts) - len(shown), "Maps show (model - truth) / truth in blocks of 4 x 4 pixels; blue is too dark:"
        )  # fmt: skip
    return "\n\n".join(parts)


def _contests(rows: list[Row], plan: Plan) -> list[str]:
    """Say where the champion is nearer to the truth than its rivals, where not, and where noise leaves it open."""
    if not rows:
        return []
    steps = ", then ".join(str(times) for times in plan.finer)
    more = f" Where noise left the order open, all had {steps} times the samples." if plan.finer else ""
    lines, doubtful = [], []
    for rival in dict.fromkeys(row["rival"] for row in rows):
        own = [row for row in rows if row["rival"] == rival]
        sure = [row for row in own if abs(row["lead"]) >= contest.SURE * row["lead_error"]]
        nearer = sum(row["lead"] > 0 for row in sure)
        lines.append(
            [title(rival), *(str(n) for n in (len(own), nearer, len(sure) - nearer, len(own) - len(sure)))]
        )
        doubtful += [row for row in own if row not in sure or row["lead"] <= 0]
    told = [
        f"{views_of([row])[0]}, {title(row['rival'])}: {1e4 * row['lead']:+.2g} ± {1e4 * row['lead_error']:.2g}"
        for row in doubtful
    ]
    return [
        paragraph(
            f"Is {title(contest.CHAMPION)} nearer to the truth? Squares of the errors in each view, compared by pairs, "
            f"so that the truth's noise counts little; the order is taken as known from {contest.SURE:g} standard "
            f"errors on.{more}"
        ),
        table(["rival", "views", f"{title(contest.CHAMPION)} nearer", "rival nearer", "open"], lines),
        *(
            [paragraph("Not nearer, or open, in 10⁻⁴ of the truth's square: " + "; ".join(told) + ".")]
            if told
            else []
        ),
    ]


def _twins(names: Sequence[str]) -> list[str]:
    left = [title(name) for name in MODELS if name not in names]
    return (
        [f"Left out, because a picture by it is the same as by another: {', '.join(left)}."] if left else []
    )


def _of_speed(samples: int) -> tuple[str, ...]:
    return (
        "*Speed*: samples a second; *efficiency*: 1 / (relative variance x seconds); medians, relative to `walk`, of",
        f"calls of {samples} samples, precomputation included.",
    )


def _overall(rows: list[Row], names: Sequence[str], timed: bool) -> str:
    lines = []
    for name in names:
        own = [row for row in rows if row["method"] == name]
        largest = max(own, key=lambda row: row["error"])
        worst = max(own, key=lambda row: abs(row["worst"]))
        lines.append(
            [
                title(name),
                percent(fmean(row["error"] for row in own), _noise(own, "error")),
                percent(largest["error"], largest["error_error"]),
                percent(fmean(abs(row["bias"]) for row in own), _noise(own, "bias")),
                f"{percent(worst['worst'], worst['worst_error'], signed=True)} ({views_of([worst])[0]})",
                *(f"{median(row[key] for row in own):.2g}" for key in ("rate", "efficiency") if timed),
            ]
        )
    head = (
        "model", "mean error %", "largest error %", "mean error of the whole light %", "worst block %",
        *(("speed", "efficiency") if timed else ()),
    )  # fmt: skip
    return table(head, lines)


def _errors(rows: list[Row], names: Sequence[str], key: Callable[[Row], str]) -> str:
    groups = list(dict.fromkeys(key(row) for row in rows))
    lines = []
    for name in names:
        cells = []
        for group in groups:
            own = [row for row in rows if row["method"] == name and key(row) == group]
            cells.append(percent(fmean(row["error"] for row in own), _noise(own, "error")))
        lines.append([title(name), *cells])
    return table(["mean error %", *groups], lines)


def _every(rows: list[Row], names: Sequence[str], views: Sequence[View]) -> str:
    lines = []
    for view in views:
        own = {row["method"]: row for row in rows if views_of([row]) == [view]}
        lines.append([str(view), *(percent(own[name]["error"], own[name]["error_error"]) for name in names)])
    return table(["view", *(title(name) for name in names)], lines)


def _noise(rows: list[Row], quantity: str) -> float:
    """Standard error of a quantity's mean over rows."""
    return fmean(row[f"{quantity}_error"] ** 2 for row in rows) ** 0.5 / len(rows) ** 0.5
