"""Scenes: meshes read, checked, repaired and placed; cameras, light rigs, and whole scenes for Mitsuba."""
