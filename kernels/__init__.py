"""Numba kernels: rays, photons, radiosity cache and camera pass. Nothing here knows files."""
