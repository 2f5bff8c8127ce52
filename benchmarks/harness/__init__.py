"""What all benchmarks share: options, tables, clocks, child processes, scenes."""
