"""Files out: a `Scene` as TOML, OBJ and MTL."""
