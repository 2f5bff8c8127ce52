"""Pixels of a pass, moments over passes, irradiance sharing."""
