"""Exit codes that commands return; None is 0."""

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Part of a data set failed; bad input; Ctrl-C, in place of which `main` reports another signal."""
