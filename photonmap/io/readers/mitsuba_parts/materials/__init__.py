"""BSDFs of Mitsuba as materials."""
