"""Marks of parameters."""

import pytest


def slow(*values):
    """Give parameters of a test that only `make test-all` runs."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]
