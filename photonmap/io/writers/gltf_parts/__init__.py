"""The parts of glTF files that are written."""
