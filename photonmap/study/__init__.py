"""What accuracy costs in time: sweeps over all that a user can choose, as a page and a table."""
