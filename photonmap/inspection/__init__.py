"""What is in a scene file: described for programs, laid out as text, and shown in a thumbnail."""
