"""What is in a scene file: described for programs, and laid out as text."""
