"""Raster kernels: loops over row slices in float32, compiled by numba without fast-math."""
