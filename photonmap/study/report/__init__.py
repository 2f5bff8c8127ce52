"""The page, plots, pictures and words of a study."""
