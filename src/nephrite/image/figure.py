"""Labelled pictures side by side, with captions, difference maps and their colour bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from nephrite.errors import ParameterError
from nephrite.image.tonemap import to_srgb8

BACKGROUND = (23, 24, 28)
STRONG = (240, 240, 242)
SOFT = (172, 175, 184)

_STOPS = ((28, 52, 138), (92, 142, 208), (226, 227, 230), (216, 112, 82), (124, 12, 34))
"""sRGB colours of the difference map from -limit over 0 to +limit."""

_SUBSTITUTES = {
    "−": "-", "–": "-", "—": "-", "‐": "-", "’": "'", "“": '"', "”": '"', "…": "...", "×": "x", "≤": "<=",
    "≥": ">=", "≈": "~", "→": "->", "σ": "sigma", "η": "eta", "β": "beta", "δ": "delta", "α": "alpha",
    "μ": "µ",
}  # fmt: skip
"""Pillow's built-in typeface covers Latin-1 only."""


@dataclass(frozen=True)
class HeatMap:
    """A map of signed values in colour: blue below 0, light grey at 0, red above.

    Attributes:
        pixels: (height, width, 3) uint8 sRGB.
        limit: Value at the ends of the colour bar; larger ones are shown as it.
    """

    pixels: NDArray[np.uint8]
    limit: float


def heat_map(values: NDArray, limit: float | None = None) -> HeatMap:
    """Colour a map of signed relative values, such as `errors.difference` returns.

    Args:
        values: (height, width); NaN is left dark.
        limit: End of the scale. Default: the 98th percentile of the sizes, rounded up to 1, 2 or 5 times a
            power of ten, and no less than 1 %.
    """
    values = np.asarray(values, np.float64)
    if values.ndim != 2:
        raise ParameterError(f"a heat map needs an array of shape (height, width), not {values.shape}.")
    known = np.abs(values[np.isfinite(values)])
    if limit is None:
        limit = _round_up(max(float(np.percentile(known, 98)), 0.01)) if known.size else 0.01
    if not limit > 0:
        raise ParameterError(f"the limit of a heat map must be positive, not {limit}.")
    pixels = _colours(np.nan_to_num(values / limit, nan=0.0))
    pixels[np.isnan(values)] = BACKGROUND
    return HeatMap(pixels, float(limit))


def side_by_side(
    images: Sequence[NDArray | HeatMap],
    labels: Sequence[str],
    title: str = "",
    captions: Sequence[str] | None = None,
    *,
    columns: int | None = None,
    width: int | None = None,
    exposure: float = 0.0,
) -> NDArray[np.uint8]:
    """Lay pictures out in a grid, each with its label above and its caption below.

    Args:
        images: Pictures of one shape (height, width, 3): linear float, or uint8 sRGB, or a `HeatMap`, which
            gets a colour bar.
        labels: One a picture; shrunk where they are too long.
        title: Above everything.
        captions: One a picture (numbers, say), broken into lines as needed; newlines are kept.
        columns: Pictures in a row. Default: all up to four, else three or four.
        width: Width of each picture in the figure, in pixels. Default: its own.
        exposure: Stops, for linear pictures; one exposure for all, so that they can be compared.

    Returns:
        (height, width, 3) uint8 sRGB, to be written as PNG.

    Raises:
        ParameterError: Nothing to show, or numbers or shapes differ.
    """
    captions = list(captions) if captions is not None else [""] * len(images)
    if not images or not len(images) == len(labels) == len(captions):
        raise ParameterError(
            f"a figure needs as many labels and captions as pictures, and at least one: "
            f"{len(images)} pictures, {len(labels)} labels, {len(captions)} captions."
        )
    if columns is not None and columns < 1:
        raise ParameterError(f"a figure needs at least one column, not {columns}.")
    shown = [_screen(image, width, exposure) for image in images]
    if len({picture.size for picture in shown}) > 1:
        raise ParameterError(f"pictures differ in size: {', '.join(str(picture.size) for picture in shown)}.")
    style = _Style(shown[0].width)
    cells = [
        _Cell(
            picture,
            _plain(label),
            _wrap(_plain(caption), _font(style.small), style.cell),
            image.limit if isinstance(image, HeatMap) else None,
        )
        for image, picture, label, caption in zip(images, shown, labels, captions, strict=True)
    ]
    columns = columns or _columns(len(cells))
    rows = [cells[start : start + columns] for start in range(0, len(cells), columns)]
    return _draw(rows, _plain(title), style)


class _Style:
    """Lengths in pixels, all in proportion to the width of a cell."""

    def __init__(self, cell: int) -> None:
        size = max(12, round(cell / 22))
        self.cell = cell
        self.size = size  # of a label's letters
        self.small = 0.72 * size  # of a caption's
        self.gap = round(0.7 * size)  # between columns
        self.space = round(0.55 * size)  # below a row
        self.line = round(1.02 * size)  # from one line of a caption to the next
        self.head = round(1.75 * size)  # height of a label
        self.bar = round(2.3 * size)  # height of a colour bar with its ticks


@dataclass(frozen=True)
class _Cell:
    picture: Image.Image
    label: str
    caption: list[str]
    limit: float | None

    def foot(self, style: _Style) -> int:
        """Return the height of what is below the picture."""
        bar = style.bar if self.limit is not None else 0
        return bar + (style.line * len(self.caption) + style.line // 2 if self.caption else 0)


def _draw(rows: list[list[_Cell]], title: str, style: _Style) -> NDArray[np.uint8]:
    top = round((2.6 if title else 0.4) * style.size)
    heights = [
        style.head + row[0].picture.height + max(cell.foot(style) for cell in row) + style.space
        for row in rows
    ]
    size = (len(rows[0]) * (style.cell + style.gap) + style.gap, top + sum(heights))
    canvas = Image.new("RGB", size, BACKGROUND)
    draw = ImageDraw.Draw(canvas)
    font = _fitting(title, 1.35 * style.size, canvas.width - 2 * style.gap)
    draw.text((style.gap, 0.56 * top), title, fill=STRONG, font=font, anchor="lm")
    y = top
    for row, height in zip(rows, heights, strict=True):
        for column, cell in enumerate(row):
            _draw_cell(canvas, cell, style.gap + column * (style.cell + style.gap), y, style)
        y += height
    return np.asarray(canvas)


def _draw_cell(canvas: Image.Image, cell: _Cell, x: int, y: int, style: _Style) -> None:
    draw = ImageDraw.Draw(canvas)
    font = _fitting(cell.label, style.size, style.cell)
    draw.text((x, y + style.head // 2), cell.label, fill=STRONG, font=font, anchor="lm")
    canvas.paste(cell.picture, (x, y + style.head))
    y += style.head + cell.picture.height
    if cell.limit is not None:
        _draw_bar(canvas, x, y, cell.limit, style)
        y += style.bar
    for number, text in enumerate(cell.caption):
        spot = (x, y + style.line * (number + 0.75))
        draw.text(spot, text, fill=SOFT, font=_font(style.small), anchor="lm")


def _draw_bar(canvas: Image.Image, x: int, y: int, limit: float, style: _Style) -> None:
    """Draw the colour bar of a heat map, with its ticks."""
    top, height = y + round(0.45 * style.size), max(4, style.size // 2)
    ramp = np.broadcast_to(_colours(np.linspace(-1.0, 1.0, style.cell)), (height, style.cell, 3))
    canvas.paste(Image.fromarray(np.ascontiguousarray(ramp)), (x, top))
    draw, percent, y = ImageDraw.Draw(canvas), 100 * limit, top + height + style.size // 4
    ticks = ((0, f"-{percent:.3g} %", "la"), (0.5, "0", "ma"), (1, f"+{percent:.3g} %", "ra"))
    for share, text, anchor in ticks:
        spot = (x + share * style.cell, y)
        draw.text(spot, text, fill=SOFT, font=_font(0.66 * style.size), anchor=anchor)


def _screen(image: NDArray | HeatMap, width: int | None, exposure: float) -> Image.Image:
    pixels = np.asarray(image.pixels if isinstance(image, HeatMap) else image)
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ParameterError(f"a picture must have the shape (height, width, 3), not {pixels.shape}.")
    screen = pixels if pixels.dtype == np.uint8 else to_srgb8(pixels, exposure)
    picture = Image.fromarray(np.ascontiguousarray(screen))
    if width is None or width == picture.width:
        return picture
    method = Image.Resampling.LANCZOS if width < picture.width else Image.Resampling.NEAREST
    return picture.resize((width, max(1, round(picture.height * width / picture.width))), method)


def _columns(count: int) -> int:
    if count <= 4:
        return count
    return 3 if count in (5, 6, 9) else 4


def _colours(scaled: NDArray) -> NDArray[np.uint8]:
    """Map [-1, 1] to the colours of the difference map."""
    at = np.linspace(-1.0, 1.0, len(_STOPS))
    channels = [np.interp(scaled, at, channel) for channel in zip(*_STOPS, strict=True)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)


def _round_up(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9)))


def _font(size: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)


def _fitting(text: str, size: float, width: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the typeface at `size`, or as much smaller as `text` needs to fit into `width`."""
    return _font(size * min(1.0, 0.98 * width / max(_font(size).getlength(text), 1.0)))


def _wrap(text: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont, width: int) -> list[str]:
    lines: list[str] = []
    for paragraph in text.splitlines():
        current = ""
        for word in paragraph.split():
            longer = f"{current} {word}".strip()
            if current and font.getlength(longer) > width:
                lines.append(current)
                longer = word
            current = longer
        lines.append(current)
    return lines


def _plain(text: str) -> str:
    """Replace characters that the typeface lacks."""
    text = "".join(_SUBSTITUTES.get(character, character) for character in text)
    return text.encode("latin-1", "replace").decode("latin-1")
