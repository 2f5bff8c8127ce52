"""Numba kernels: rays, photons, irradiance store and camera pass. Nothing here knows files."""
