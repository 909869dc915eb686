"""Pass sizes: they add up, are powers of two, and stay within memory and time."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nephrite.rendering import schedule

PIXELS = st.integers(1, 10_000_000)


def whole_schedule(total, pixels, samples):
    size, done, passes = schedule.chunk(total, pixels, samples), 0, []
    while done < total:
        passes.append(schedule.fixed(done, total, size))
        done += passes[-1]
    return passes


@given(st.integers(1, 3000), PIXELS, st.integers(1, 2**24))
def test_a_fixed_schedule_adds_up_in_powers_of_two_within_memory(total, pixels, samples):
    passes = whole_schedule(total, pixels, samples)
    assert sum(passes) == total
    assert all(spp & (spp - 1) == 0 for spp in passes)
    assert all(spp == 1 or spp * pixels <= samples for spp in passes)
    assert passes[0] == 1
    assert len(passes) >= min(total, schedule.MIN_PASSES)


def test_known_schedules():
    assert whole_schedule(64, 64 * 64, 2**20) == [1, 1, 2, 4] + 7 * [8]
    assert whole_schedule(4, 64 * 64, 2**20) == [1, 1, 1, 1]
    assert whole_schedule(100, 800 * 600, 2**20) == 2 * [1] + 49 * [2]
    assert whole_schedule(3, 3840 * 2160, schedule.MAX_SAMPLES) == [1, 1, 1]  # 8.3 M pixels


@given(st.floats(1e-6, 100), st.floats(-1, 1000), st.integers(1, 4096), PIXELS)
def test_a_timed_pass_ends_in_time_or_is_none(rate, left, previous, pixels):
    largest = schedule.largest_pass(pixels, schedule.MAX_SAMPLES)
    spp = schedule.timed(rate, left, previous, largest)
    assert spp * rate <= max(left, 0)
    assert spp * rate <= max(schedule.PASS_SECONDS, rate)
    assert spp <= max(1, min(largest, 4 * previous))
    assert spp >= (1 if left >= rate else 0)


@given(st.floats(1e-9, 1e12))
def test_powers(number):
    floor, ceil = schedule.floor_power(number), schedule.ceil_power(number)
    assert floor <= max(number, 1) < 2 * floor
    assert ceil / 2 < max(number, 1) <= ceil


def test_seeds_are_fixed_32_bit_and_differ():
    firsts = [schedule.first_seed(seed) for seed in range(2000)]
    assert len(set(firsts)) == 2000
    assert all(0 <= first < 2**32 for first in firsts)
    assert schedule.first_seed(2**70) != schedule.first_seed(0)
    # Renders of neighbouring seeds share no pass: the first seeds are far apart.
    ordered = sorted(firsts[:50])
    assert min(b - a for a, b in itertools.pairwise(ordered)) > 1000


@pytest.mark.parametrize(
    ("pixels", "spp"), [(1, 2**23), (4096, 2048), (480_000, 16), (8_294_400, 1), (10**8, 1)]
)
def test_largest_pass(pixels, spp):
    assert schedule.largest_pass(pixels, schedule.MAX_SAMPLES) == spp
