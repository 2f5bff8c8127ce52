"""The caustic photon map."""
