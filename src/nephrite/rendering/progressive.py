"""Renders pass by pass with any Mitsuba integrator, until samples, time or noise are reached."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.errors import ParameterError
from nephrite.rendering import schedule
from nephrite.rendering.accumulate import Accumulator
from nephrite.rendering.goal import MAX_SPP, Clock, Goal
from nephrite.rendering.interrupts import postponed_interrupts
from nephrite.rendering.result import Progress, Result


def render(
    scene: Any,
    integrator: Any = None,
    spp: int | None = None,
    time_s: float | None = None,
    noise: float | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    seed: int = 0,
    *,
    sensor: int | Any = 0,
    max_samples: int = schedule.MAX_SAMPLES,
    pass_samples: int | None = None,
) -> Result:
    """Render in passes, each an independent picture, and return their mean with its noise.

    Ends at the first of the goals that is reached: `spp` samples per pixel, `time_s` seconds, relative noise
    `noise`. Without any, the number of samples of the sensor's sampler. As long as no time is given, the
    passes and so the picture depend on scene, `seed` and goals alone.

    Ctrl-C ends the render after the pass that is running, and the picture so far is returned; a second Ctrl-C
    ends at once. If there is nothing yet, `KeyboardInterrupt` is raised.

    Values that are NaN or infinite never reach the mean: that pixel is left out of that pass and counted.

    Args:
        scene: A loaded Mitsuba scene.
        integrator: A Mitsuba integrator. Default: the scene's.
        spp: Samples per pixel; beside another goal, the most of them.
        time_s: Seconds, compilation included; the last pass is chosen to end in time.
        noise: Such as 0.01 for 1 %, as `Result.noise` defines it.
        on_progress: Called after every pass.
        seed: Any integer from 0; the passes' own seeds follow from it.
        sensor: Index of a sensor of the scene, or a Mitsuba sensor.
        max_samples: Most samples (pixels x spp) of a pass, for memory's sake; one a pixel is always allowed.
        pass_samples: Samples of a usual pass when time does not decide. Default: 2^20, 2^23 on CUDA.

    Raises:
        ParameterError: A goal, the seed or a limit has an impossible value.
    """
    camera = scene.sensors()[sensor] if isinstance(sensor, int) else sensor
    _check(spp=spp, time_s=time_s, noise=noise, max_samples=max_samples, pass_samples=pass_samples)
    if isinstance(seed, bool) or seed != int(seed) or seed < 0:
        raise ParameterError(f"seed must be an integer from 0, not {seed!r}.")
    if spp is None and time_s is None and noise is None:
        spp = camera.sampler().sample_count()
    goal = Goal(spp, time_s, noise)

    pixels = math.prod(camera.film().crop_size())
    largest = schedule.largest_pass(pixels, max_samples)
    backend = "cuda" if (mi.variant() or "").startswith("cuda") else "llvm"
    samples = min(pass_samples or schedule.PREFERRED_SAMPLES[backend], max_samples)
    chunk = schedule.chunk(int(min(goal.most_spp, 2**31)), pixels, samples)
    base, clock, seen, stopped = schedule.first_seed(seed), Clock(), None, ""
    reached = math.inf

    try:
        with postponed_interrupts() as interrupted:
            while not stopped:
                lap = clock.seconds()
                size = _next_pass(goal, seen, reached, clock, chunk, largest)
                if size == 0:
                    stopped = "time"
                    break
                number = seen.passes if seen else 0
                picture, size = _one_pass(scene, camera, integrator, size, (base + number) % 2**32)
                # Replaced as a whole, so an interrupt finds it either before or after this pass.
                seen = (seen or Accumulator.empty(*picture.shape[:2])).add(picture, size)
                clock.laps.append((clock.seconds() - lap, size))
                reached = seen.noise()
                stopped = goal.reached(seen, clock.seconds(), reached)
                if on_progress is not None:
                    on_progress(_progress(goal, seen, reached, clock, bool(stopped)))
                if interrupted.is_set() and not stopped:
                    stopped = "interrupted"
    except KeyboardInterrupt:
        if seen is None:
            raise
        stopped = "interrupted"
    assert seen is not None
    return Result(
        pixels=seen.mean,
        variance=seen.variance(),
        noise=seen.noise(),
        spp=seen.spp,
        seconds=clock.seconds(),
        passes=seen.passes,
        interrupted=stopped == "interrupted",
        stopped=stopped,
        dropped=seen.dropped,
        seed=int(seed),
        notes=_notes(seen, stopped, noise),
    )


def _check(**goals: float | None) -> None:
    for name, value in goals.items():
        if value is None:
            continue
        if name in ("time_s", "noise"):
            if not (value > 0 and math.isfinite(value)):
                raise ParameterError(f"{name} must be positive and finite, not {value!r}.")
        elif isinstance(value, bool) or value != int(value) or value < 1:
            raise ParameterError(f"{name} must be a whole number from 1, not {value!r}.")


def _one_pass(
    scene: Any, sensor: Any, integrator: Any, spp: int, seed: int
) -> tuple[NDArray[np.float32], int]:
    """Render once; return the colours, and the spp that the sampler made of `spp` (some round it)."""
    sampler = sensor.sampler().clone()
    sampler.set_sample_count(spp)
    start: Any = seed  # Mitsuba's declaration wants a UInt32, which no integer is before a variant is set
    image = mi.render(scene, sensor=sensor, integrator=integrator, seed=start, spp=spp)
    picture = np.array(image, np.float32)
    if picture.ndim == 2:
        picture = picture[..., None]
    colours = picture[..., :3] if picture.shape[2] >= 3 else np.repeat(picture[..., :1], 3, axis=2)
    return colours, sampler.sample_count()


def _next_pass(
    goal: Goal, seen: Accumulator | None, noise: float, clock: Clock, chunk: int, largest: int
) -> int:
    """Return the spp of the next pass, 0 if there is no time for one."""
    if seen is None:
        return 1
    if goal.time_s is not None:
        rate = clock.seconds_per_spp()
        if rate is None:
            return 1
        size = schedule.timed(rate, goal.time_s - clock.seconds(), clock.laps[-1][1], largest)
    else:
        size = schedule.fixed(seen.spp, int(goal.most_spp), chunk)
    missing = goal.wanted_spp(seen, noise) - seen.spp
    if math.isinf(missing):
        return size
    return min(size, schedule.floor_power(goal.most_spp - seen.spp), schedule.ceil_power(missing))


def _progress(goal: Goal, seen: Accumulator, noise: float, clock: Clock, ended: bool) -> Progress:
    seconds, rate = clock.seconds(), clock.seconds_per_spp()
    target, left = goal.wanted_spp(seen, noise), math.inf
    if goal.noise is not None and goal.spp is None and target == MAX_SPP:
        target = math.inf  # nothing is known yet, or the cap is all that is known
    if rate is not None:
        left = max(0.0, rate * (target - seen.spp))
        if goal.time_s is not None and goal.time_s - seconds < left:
            left = max(0.0, goal.time_s - seconds)
            target = seen.spp + left / rate
    elif goal.time_s is not None:
        left = max(0.0, goal.time_s - seconds)
    if ended:
        target, left = seen.spp, 0.0
    fraction = seconds / (seconds + left) if goal.time_s is not None else seen.spp / target
    return Progress(
        spp=seen.spp,
        target=round(target) if math.isfinite(target) else None,
        seconds=seconds,
        remaining_s=left if math.isfinite(left) else None,
        noise=noise,
        passes=seen.passes,
        fraction=min(1.0, fraction),
    )


def _notes(seen: Accumulator, stopped: str, noise: float | None) -> tuple[str, ...]:
    notes = []
    if seen.dropped:
        share = seen.dropped / (seen.passes * seen.mean.shape[0] * seen.mean.shape[1])
        notes.append(
            f"{seen.dropped} pixel values were NaN or infinite and were left out ({share:.2g} of all)."
        )
    if stopped == "cap":
        notes.append(f"the noise {noise:.3g} was not reached in {seen.spp} samples per pixel.")
    if not seen.mean.any():
        notes.append("the picture is black: no light reaches the camera. Check lights, camera and materials.")
    return tuple(notes)
