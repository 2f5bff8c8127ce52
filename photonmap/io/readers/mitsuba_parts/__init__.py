"""Parts of the reader of Mitsuba scenes."""
