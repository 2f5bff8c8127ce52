"""Wavefront's text formats: OBJ geometry and MTL materials."""
