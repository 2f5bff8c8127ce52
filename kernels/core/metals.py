"""Constants of what metals reflect: see `core.fresnel`."""

DIP_POWERS = (2, 4, 10, 12)  # Of 1 - μ, in `core.fresnel.dip_terms`
DIP_MEANS = tuple(4.0 / ((p + 1.0) * (p + 2.0) * (p + 3.0)) for p in DIP_POWERS)
"""Cosine-weighted means of these"""
