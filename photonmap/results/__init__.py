"""What a render returns: buffers, errors, the run record; saved, loaded and merged."""
