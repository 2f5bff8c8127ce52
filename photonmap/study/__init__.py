"""What accuracy costs in time: sweeps over the options of a render, their points, a report."""
