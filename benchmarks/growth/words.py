"""What the page of growth says in words."""

from __future__ import annotations

HEAD = """
What becomes of time and memory as scenes grow: benchmark scene B1, the skim-milk dragon under one lamp and a dim sky,
changed in one thing at a time, beside [the benchmark's](benchmark.md) peers. Each method runs in a process of its own.
"""

QUICK = "**A quick run: whether everything works, too short for its numbers to mean anything.**"

TRIANGLES = """
The dragon's resolutions, 100 mm long, {resolution} pixels. *Seconds* are those of a picture with so many
samples a pixel, after one that has compiled the kernels: the mean of two calls, and what is precomputed, which
the first call with an integrator takes longer. Loading the scene is apart; Cycles builds its own in its first call,
and of its seconds what a call with one sample takes is taken off. *x*: relative to the fewest triangles.
"""

SIZE = """
The body's longest side, and light, floor and camera with it; so its optical thickness grows alike. *Seconds to 1 %*:
until the variance, relative to the squared mean, over the object's pixels is 0.01: seconds of {spp} samples times the
variance between two pictures of so many, over 0.01, and once what is precomputed. Noise that two pictures have in
common, as that of precomputed transport, is no part of it: [the atlas](atlas.md) has it as an error. *x*: relative to
the smallest. *Computed*: the model that Nephrite has used; `transport` leaves to `walk` what is too thin for its nodes,
and what needs more of them than it has.
"""

RESOLUTION = """
The command line, a process from beginning to end, in passes that it chooses by itself, and denoised as every PNG, with
{few} samples:

```
nephrite render dragon --material "skim milk" --light benchmark --resolution 3840x2160 --model walk --spp {few}
```

*Peak* is the largest resident size of the process.
"""

G = """
B1's medium with sigma_s' = sigma_s (1 - g) kept, so that by similarity all of these would look the same. `walk`
scatters by g itself; the walks of `transport` use similarity where it is safe, once they have forgotten their
direction, which is within .2 % ([physics](physics.md), `benchmarks/similarity.py`). From the first event on it would
not be safe: the table has the picture at g = 0 less the one at g, relative to this; *error* is its root mean square
over blocks of 8 x 8 pixels, less noise, *worst block* of 16 x 16. Seconds as above.
"""

FIRST = """
Timed from outside: from the start of the process to its end, with the picture on disk. The dragon has been fetched
before.

```
nephrite render dragon --material "skim milk" --light benchmark --resolution {resolution} --model walk --time {time}
nephrite render dragon --material "skim milk" --light benchmark --resolution {resolution} --model transport --spp {good}
```

`walk` has blotches of colour, as each of its few samples tells of little more than one colour. Those of
`transport` are faint, but it takes longer: it precomputes for some seconds, and compiles more.

*Kernels kept*: whether Dr.Jit finds those that an earlier process has compiled; without them, it is the first picture
after an installation.
"""

AGAIN = """
## Again

```
make growth                      # the peers into .venv-bench, then all of this; again: what is missing
make growth GROWTH=--quick       # small pictures, into out/bench-quick
make growth GROWTH=--help        # a part of it, a shorter time
```
"""
