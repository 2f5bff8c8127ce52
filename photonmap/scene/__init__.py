"""What a user builds: meshes, materials, textures, lights and a camera, which check themselves."""
