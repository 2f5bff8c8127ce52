"""Write scenes as files that `photonmap.readers` reads back."""
