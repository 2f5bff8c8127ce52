"""Limits of the system, for as long as a test wants them."""

import resource
from contextlib import contextmanager


@contextmanager
def files_of_at_most(size):
    """Have writing fail beyond so many bytes of a file, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
