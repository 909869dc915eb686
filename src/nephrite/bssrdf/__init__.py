"""From a diffusion profile or a walk to light between two points of a surface."""
