"""How surfaces scatter light: diffuse reflectance, mirrors, dielectrics."""
