"""Shapes, furniture and other objects that procedural scenes are made of."""
