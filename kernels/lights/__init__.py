"""Emitters: sampled towards a point, chosen among many, emitting photons."""
