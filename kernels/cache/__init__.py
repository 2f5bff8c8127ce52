"""The radiosity cache: diffusely reflected light kept in cells of the surface."""
