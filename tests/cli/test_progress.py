"""What the progress bar says."""

from __future__ import annotations

import math

import pytest

from nephrite.cli import progress
from nephrite.rendering.result import Progress


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "0s"), (59.4, "59s"), (125, "2m05s"), (3723, "1h02m"), (-1, "0s")]
)
def test_times_are_short(seconds: float, text: str) -> None:
    assert progress.clock(seconds) == text


def test_samples_noise_and_time_left_are_told() -> None:
    running = Progress(8, 64, 4.0, 28.0, 0.0312, 4, 0.125)
    assert progress.state(running) == "8/64 spp, noise 3.12%, 28s left"
    first = Progress(1, None, 2.0, None, math.inf, 1, 0.0)
    assert progress.state(first) == "1 spp"


def test_nothing_is_shown_where_no_one_looks() -> None:
    with progress.shown("jade") as listen:
        assert listen is None
