"""Cameras: rays through points of the film."""
