"""Lights as kernels take them: emitters, the sky, probabilities and the light tree."""
