"""What `tools/blender_export.py` exports, part by part; it runs inside Blender."""
