"""Triangles as plain arrays: how they hang together, and which side of them is outside."""
