"""What the benchmark's page says in words."""

from __future__ import annotations

RULES = """
Each method runs in a process of its own, one after the other, in {rounds} rounds: every method once, then every method
again (LuxCore, which takes minutes, and those that no ratio is asked of, in the first alone). It loads the scene and
warms up with one sample per pixel; then it renders pairs of pictures of 1, 2, 4, ... samples until {each:g} s are
spent. A method that precomputes much for each picture renders two pairs: with few samples, and with as many as make a
picture of about {each:g} s, of which precomputation has about half at most; and one more with a number between the two,
where they are far apart. *Seconds* are those of the whole call that makes a picture: tables and precomputation for it
are included, loading the scene is not. Cycles prepares the scene in that call, and writes a file: what a call with one
sample takes is taken off.
"""

MEASURES = """
The *reference* is Nephrite's walk with exact exits, which tests compare with `volpathmis`, rendered until its own
relative variance is 1 %, or for as long as it may, in B1 three times as long as in the others. *relMSE* is the mean of
(picture - reference)² / (mean² + 0.01) over the object's pixels, less the reference's own variance; the mean is the
reference's over 5 x 5 pixels, as its own noise would count more where it is dark by chance. *Seconds to 1 %*: until it
falls to 0.01, noise and bias together: read off the curve; with ~ extrapolated beyond its end, where noise falls as 1 /
samples and what is precomputed is paid once; with < the curve's first point; - where bias alone is more. *Noise alone*:
the same if there were no bias. *Efficiency*, of the last pair, is mean² / (variance x seconds): twice as much is half
the time to the same noise. *Bias* and *worst block* (of 16 x 16 pixels) are relative errors of all pictures together;
what is smaller than twice its standard error is given as < limit. *Around* is the bias of all other pixels: floor, sky
and shadows. Ratios are to `{base}`, round by round: geometric mean, and in brackets the least and the largest of the
rounds; above 1 is better. *Memory* is the largest resident size of the process.
"""

ASKED = """
Efficiency is that of pictures as long as each method's last pair, in which precomputation is paid for; *time to 1 %* is
shorter, and there most of it is precomputation: [levers](levers.md) tells of what.
"""

FASTER = """
How many times faster than Cycles' random walk each method is to 1 %. Its own bias is counted against a method; Cycles'
is not counted against Cycles, which with it would not get there: its time is that in which its noise falls to 1 %.
"""

MATERIALS = """
Mitsuba, Nephrite and LuxCore get the coefficients, in 1/mm. Cycles gets the colour that a thick piece of the same
medium shows under its surface, by the exact map of [materials](materials.md), and its reduced mean free path 1 /
(sigma_a + sigma_s (1 - g)) in mm, times 4 π: it divides a radius by that. *Unscaled* is Cycles with the mean free
path itself as the radius, which makes a medium that is 12.6 times as dense.
"""

COMPARABLE = (
    """
**Mitsuba `volpath` and `volpathmis`** solve the same equation as the exact walk: they differ from the reference by
noise alone.
""",
    """
**Cycles** takes colour and radius, not coefficients, and turns the colour into an albedo by a fit of its own. Its
walk leaves the object as diffuse light: there is no reflection inside, and light that leaves unscattered or scattered
once (S(0), S(1)) has no direction of its own. To show the same colour without reflection inside, its medium absorbs
more, so that less gets through thick parts. A walk ends after 256 steps, a path after 16 bounces. So it differs from
the reference as another model does, and its relMSE has a floor that is no fault of its sampling: for its noise alone,
see the efficiency.
""",
    """
**Burley** is a profile, as Nephrite's `tabulated` and `dipole` are: flat and thick, whatever the object.
""",
    """
**LuxCore** solves the same equation, but its volumes behind glass do not keep the light: in a white furnace an object
that absorbs nothing is not white, and single samples of huge weight decide the mean (version 2.11.2). So its error
does not fall with time. It samples one distance for all colours; here each channel is rendered alone, with a grey
medium, and a picture is three renders. It gets the mesh without smooth normals, and no Russian roulette: both make it
worse.
""",
    """
**`brdf`** is what a renderer without subsurface scattering shows; it has no place in a race, but says what light and
surface alone cost.
""",
    """
A sample of one renderer is not one of another: Msamples/s compare no renderers. Memory includes the program itself:
Python, Blender's libraries, compiled kernels.
""",
)

AGAIN = """
## Again

```
make bench                   # the peers into .venv-bench, then all of this; again: what is missing
make bench BENCH=--quick     # small pictures, a few seconds for each, into out/bench-quick
make bench BENCH=--help      # a shorter time, fewer scenes or methods, the GPU
```
""".strip()
