"""Files of scenes and images: readers, writers, OpenEXR and PNG."""
