"""Pictures of translucent objects while lights move: transport in place, a frame in a fraction of a second."""

from nephrite.relighting.precomputed import Precomputed, load, precompute
from nephrite.relighting.viewer import Viewer

__all__ = ["Precomputed", "Viewer", "load", "precompute"]
