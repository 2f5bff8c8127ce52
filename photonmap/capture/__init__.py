"""What a camera makes of a render: exposure, noise, mosaic, raw files and their development."""
