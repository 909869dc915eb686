"""Precomputed subsurface transport: nodes on a surface, what walks carry between them, and how pixels look it up."""
