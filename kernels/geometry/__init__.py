"""Rays and surfaces: Embree, surface interactions, textures, opacity."""
