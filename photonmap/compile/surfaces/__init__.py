"""Surfaces as kernels take them, beyond what their materials reflect."""
