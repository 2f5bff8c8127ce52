"""A page that shows the buffers of a render and the spectra of its pixels, in any browser."""
