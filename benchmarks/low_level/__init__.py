"""Benchmarks of rays and of the parts of a pass."""
