"""Generated rooms: kinds, functional groups of furniture, layout, and the camera."""
