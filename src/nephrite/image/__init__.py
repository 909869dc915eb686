"""Pictures after rendering: writing, tone mapping, denoising, error measures, labelled comparisons.

A picture is a float32 array of shape (height, width, 3): linear light, sRGB primaries, first row on top.
Only figures and tone mapped pictures are uint8. The modules are imported one by one, as in
``from nephrite.image import write``, so that nothing is loaded that is not used.
"""
