"""The bench: what a data set gives to methods, how their estimates are scored and summed up."""
