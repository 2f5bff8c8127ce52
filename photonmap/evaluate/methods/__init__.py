"""Baseline methods, one file each: decomposition into reflectance and shading, and illuminants."""
