"""Figures: every picture is in them unchanged, text stays inside, maps have the right colours."""

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.image import figure
from nephrite.image.tonemap import to_srgb8


@pytest.fixture
def pictures():
    return list(np.random.default_rng(5).uniform(0, 1, (7, 30, 160, 3)).astype(np.float32))


def places(whole, part):
    """Return where `part` is in `whole`, as a list of (row, column)."""
    height, width = part.shape[:2]
    rows, columns = whole.shape[0] - height + 1, whole.shape[1] - width + 1
    corners = np.argwhere((whole[:rows, :columns] == part[0, 0]).all(axis=2))
    return [(y, x) for y, x in corners if np.array_equal(whole[y : y + height, x : x + width], part)]


@pytest.mark.parametrize(("count", "across"), [(1, 1), (3, 3), (4, 4), (5, 3), (7, 4)])
def test_pictures_are_in_a_grid_in_order(pictures, count, across):
    whole = figure.side_by_side(pictures[:count], [f"picture {i}" for i in range(count)], "title")
    assert whole.dtype == np.uint8
    spots = [places(whole, to_srgb8(picture)) for picture in pictures[:count]]
    assert all(len(spot) == 1 for spot in spots)
    rows = sorted({spot[0][0] for spot in spots})
    columns = sorted({spot[0][1] for spot in spots})
    assert len(columns) == across
    assert [spot[0] for spot in spots] == [(rows[i // across], columns[i % across]) for i in range(count)]


def test_one_exposure_and_eight_bit_pictures_as_they_are(pictures):
    eight_bit = to_srgb8(pictures[1])
    whole = figure.side_by_side([pictures[0], eight_bit], ["a", "b"], exposure=-1.0)
    assert places(whole, to_srgb8(pictures[0], -1.0))
    assert places(whole, eight_bit)


def test_text_is_drawn_and_stays_within_its_column(pictures):
    def ink(*, label="", title="", caption=""):
        whole = figure.side_by_side([pictures[0], pictures[0]], [label, ""], title, [caption, ""])
        drawn = (whole != figure.BACKGROUND).any(axis=2)
        for y, x in places(whole, to_srgb8(pictures[0])):
            drawn[y : y + 30, x : x + 160] = False
        return np.argwhere(drawn)

    assert len(ink()) == 0
    for text in ({"label": "a label " * 9}, {"caption": "numbers of every kind " * 9 + "\nline"}):
        marks = ink(**text)
        assert len(marks) > 50
        assert marks[:, 1].max() < 185
    assert len(ink(title="A title")) > 50


def test_captions_make_room_for_themselves(pictures):
    short, long = (
        figure.side_by_side(pictures[:1], ["a"], captions=[text]) for text in ("one", "one\ntwo\nthree")
    )
    assert long.shape[0] > short.shape[0] + 15
    assert places(short, to_srgb8(pictures[0])) == places(long, to_srgb8(pictures[0]))


def test_width_scales_the_pictures(pictures):
    half = figure.side_by_side(pictures[:2], ["a", "b"], width=80)
    assert 160 < half.shape[1] < 220


def test_characters_that_the_typeface_lacks_are_replaced():
    assert figure._plain("σ_a − 5 × 10…") == "sigma_a - 5 x 10..."
    assert figure._plain("翡翠 ± 1 µm") == "?? ± 1 µm"


def test_heat_map_colours_follow_the_sign_and_the_size():
    values = np.array([[-0.5, -0.1, -0.05, 0.0, 0.05, 0.1, 0.5, np.nan, np.inf]])
    heat = figure.heat_map(values, limit=0.1)
    red, _, blue = heat.pixels[0].astype(int).T
    assert np.array_equal(heat.pixels[0, 0], heat.pixels[0, 1])  # beyond the limit: its colour
    assert np.array_equal(heat.pixels[0, 5], heat.pixels[0, 6])
    assert np.array_equal(heat.pixels[0, 5], heat.pixels[0, 8])
    assert (blue > red + 80)[[0, 1, 2]].all()
    assert (red > blue + 80)[[4, 5, 6]].all()
    assert np.ptp(heat.pixels[0, 3].astype(int)) < 8
    assert tuple(heat.pixels[0, 7]) == figure.BACKGROUND


@pytest.mark.parametrize(
    ("size", "limit"), [(0.0, 0.01), (0.013, 0.02), (0.031, 0.05), (0.2, 0.2), (0.7, 1.0)]
)
def test_the_scale_is_a_round_number(size, limit):
    assert figure.heat_map(np.full((4, 4), size)).limit == pytest.approx(limit)


def test_a_few_wild_pixels_do_not_set_the_scale():
    values = np.full((50, 50), 0.04)
    values[0, :20] = 30.0
    assert figure.heat_map(values).limit == pytest.approx(0.05)
    assert figure.heat_map(np.full((4, 4), np.nan)).limit == pytest.approx(0.01)


def test_a_heat_map_has_a_colour_bar(pictures):
    heat = figure.heat_map(np.zeros((30, 160)), limit=0.1)
    plain = figure.side_by_side([heat.pixels], ["a"])
    whole = figure.side_by_side([heat], ["a"])
    assert whole.shape[0] > plain.shape[0]
    ramp = figure._colours(np.linspace(-1, 1, 160))
    assert len(places(whole, np.broadcast_to(ramp, (4, 160, 3)))) >= 1
    assert not places(plain, np.broadcast_to(ramp, (4, 160, 3)))


def test_misuse_is_refused(pictures):
    for arguments, reason in (
        (([], []), "at least one"),
        ((pictures[:2], ["a"]), "labels"),
        ((pictures[:1], ["a"], "", ["b", "c"]), "captions"),
        (([pictures[0], pictures[1][:20]], ["a", "b"]), "size"),
        (([pictures[0][..., 0]], ["a"]), "shape"),
    ):
        with pytest.raises(ParameterError, match=reason):
            figure.side_by_side(*arguments)
    with pytest.raises(ParameterError, match="column"):
        figure.side_by_side(pictures[:1], ["a"], columns=0)
    with pytest.raises(ParameterError, match="limit"):
        figure.heat_map(np.zeros((2, 2)), limit=0.0)
    with pytest.raises(ParameterError, match="shape"):
        figure.heat_map(np.zeros((2, 2, 3)))
