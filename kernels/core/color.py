"""Constants of colour."""

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear sRGB's red, green and blue in the luminance Y, IEC 61966-2-1"""
