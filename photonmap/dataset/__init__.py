"""Scenes for data sets of ground truth: built from a seed, relit, recoloured."""
