"""Kinds of lights that need more than `photonmap.scene.lights` holds."""
