"""The files of a data set: layout, manifest, formats, readers, statistics."""
