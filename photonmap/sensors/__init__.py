"""What a number of bands costs: errors after interreflection, in the bands and as colours."""
