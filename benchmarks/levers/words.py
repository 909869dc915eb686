"""What the page of the levers says in words."""

from __future__ import annotations

MADE = "<!-- Made by `python -m benchmarks.levers`: change the code in benchmarks/levers, not this page. -->"

HEAD = """
What makes `walk` and `transport` fast, and what each part of it is worth: benchmark scene B1, the skim-milk dragon, at
{resolution} pixels, rendered with all levers and without each in turn. *Worth* is the efficiency, mean² / (variance x
seconds) over the object's pixels, with all of them over that without the one: 2 is half the time to the same noise.
`walk` with {walk} samples a pixel, `transport` with {transport}, its precomputation counted for each picture. Rounds of
all: {rounds}; where there are several, in brackets the least and the largest; where there is one, nothing tells how
sure the figures are, and those of a model share the noise of its one run with all levers. What is worth less than that
pays elsewhere, or in the picture's worst pixels.

Version {version}, {cores} processor cores, measured from {first} to {last} UTC.
"""

TITLES = {"walk": "The walk", "transport": "Precomputed transport"}

WHERE = """
Of one picture of each model. Kernels are what Dr.Jit has compiled, with Embree's rays in them; several may run beside
NumPy. Rays of `transport` include those of its walks. Compiling is what an empty cache of kernels costs; the next
process finds them there.
"""

NOISE = """
Each term rendered alone: the variance of a picture over the squared mean of all light, over the object's pixels. What
is precomputed is a part of it, as it differs from picture to picture. *Place on the lamp*: what each place of the lamp
would bring to what the camera sees, its variance over the squared mean, were nothing in the way.

So what lamps sampled by solid angle could gain is the last row, at most. What connections of single scattering to lamps
could gain that are refracted at the surface is the noise of `single`, at most. Each would be found by iteration, a ray
for every step of it; and where several points of a curved surface refract a lamp's light to one point inside, all of
them would have to be found, or light be lost. Neither has been built.
"""

DROPPED = """
## Tried and not kept

No command repeats these, as their code is gone; so here are no figures.

- *Steps deep inside that need no ray*, by a grid of distances to the surface: a third to a half of a walk's rays went,
  and none of its time. They were the cheap ones: short rays far from any triangle.
- *More turns toward lamps, or a sharper lobe*: single scattering gets less noisy, what scatters again more so. In thick
  parts all guiding loses.
- *Turns and free paths stretched toward the face that the walk has entered by* (Dwivedi's guiding), at the strength
  that the albedo of skim milk asks for: shorter walks, and more noise than they save; at twice the strength, far more.
  A walk that is nearly white gets out of everything, and few of its events are near a flat face.
- *Compacting long tails* into full vectors: nothing beside lanes that start their next path; vectors of 4 and 8 lanes
  in place of 16 neither.
- *Walks of `transport` that also begin where light falls*: it would depend on the light, for no less relative noise.
- *Transport looked up where a path has first scattered*, not where it entered: less noise, as no directions need be
  remembered at the camera's end, and more bias.
- *Directions remembered between narrower cells*: closer to the walk by what `benchmarks/transport.py` can hardly tell
  from noise, which grows; as *means between narrower cells*.
- *More paths a lane*, so that fewer wait for the slowest: nothing, from 8 to 256.
- *One shadow ray for all lights*, chosen by what each would bring: fewer rays, more noise, less efficiency.
- *Light's share that scatters twice, sampled at the light's end too*: brighter and darker blocks than without.
- *Lanes that start side by side and wait for each other*, in models of short paths (`brdf`, `dipole`): nothing that
  could be told from noise.
- *The sky by a shadow ray along the lobe, and fewer paths that go on from there*, in `dipole`: its noise is that of
  light between surfaces, not the sky's, so that it grew as fast as rays went.
- *Thinning of `transport`'s walks from another order on* than 64: noise times time is least there.
- *Light between surfaces by paths that follow each other in a lane, with even first directions*, where it is gathered
  for `transport`: less noise, where there is little, and no time.
- *What is precomputed, counted whether a surface mirrors or not, and mirrors chosen more often*: nothing, then more
  noise.
"""

AGAIN = """
## Again

```
.venv/bin/python -m benchmarks.levers            # some 20 minutes, two rounds; again: what is missing
.venv/bin/python -m benchmarks.levers --quick    # small pictures, into out/bench-quick
```
"""
