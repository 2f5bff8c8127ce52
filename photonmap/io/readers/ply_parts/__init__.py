"""What PLY files consist of."""
