"""Scene files read into scenes: OBJ, MTL, and the TOML beside them."""
