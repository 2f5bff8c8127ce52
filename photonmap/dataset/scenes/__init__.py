"""Procedural scenes: rooms and objects, their views and illumination."""
