"""Files in: one module a format, which `registry` finds by the suffixes that it declares.

A module here that reads a format declares two names, and no other module mentions it:

SUFFIXES : tuple of str
    written out on one line, for it is read without importing the module: (".ply",)
read : Path, ReadOptions -> Scene
    meshes with their materials, and the lights and the camera where the format has them

What is wrong with a file, or with one that it names, is an `InputError` wherever it is found.
"""
