"""What all kernels stand on: JIT decorators, records, random numbers, warps, vectors, bands."""
