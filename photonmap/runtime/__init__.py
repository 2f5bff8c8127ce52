"""What every run needs: threads, memory, checkpoints, progress, wording of messages."""
