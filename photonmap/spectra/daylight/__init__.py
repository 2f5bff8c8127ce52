"""The sun and a clear sky as spectra."""
