"""Materials: Munsell chips, patterns and finishes."""
