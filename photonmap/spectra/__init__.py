"""Spectra: curves and their names, measured sets, bands, and colorimetry."""
