"""Bodies of glass: what lies inside them, beside them and within each other."""
