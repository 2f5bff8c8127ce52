"""What glTF files say of surfaces: materials and textures."""
