"""What USD stages hold: meshes, preview surfaces, lights and cameras. Imported only with pxr."""
