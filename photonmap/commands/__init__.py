"""The command line: one file a command, each with arguments, printing and exit codes alone."""
