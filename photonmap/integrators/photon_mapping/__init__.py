"""Photon mapping: photons, the radiosity cache, and caustics."""
