"""Curves over wavelength, the names they go by, and the eye that sees them."""
