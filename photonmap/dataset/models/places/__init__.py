"""What stands in particular rooms, and outdoors."""
