"""The work of a data set: presets, the list of jobs, schedule, rendering, verification."""
