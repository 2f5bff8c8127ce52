"""Photon tracing, the camera pass, final gathering, path tracing."""
