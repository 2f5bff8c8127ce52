"""Benchmarks of errors against time, references and other renderers."""
