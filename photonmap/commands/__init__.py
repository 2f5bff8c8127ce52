"""The command line: a module for each command, whose `run` returns an exit code; None is 0."""

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Part of the work failed; bad input; Ctrl-C, in place of which `main` reports another signal."""
