"""The accuracy atlas: every model of subsurface scattering measured against the truth, and a page that says so."""
