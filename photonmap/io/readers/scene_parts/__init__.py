"""What TOML scenes describe: cameras, lights, and materials of a mesh file and its objects."""
