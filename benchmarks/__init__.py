"""Measurements of speed, memory and accuracy: `python -m benchmarks [NAME ...]`.

Each benchmark is one file with a function `run` that takes `Options` and returns tables.
"""
