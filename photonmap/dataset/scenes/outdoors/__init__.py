"""Gardens, terraces and streets under a sky."""
