"""The compiled kernel: the hybrid flow of a planar body on springy legs, with exact derivatives.

Plain arrays in, plain arrays out; see `legspring.kernel.walker` for units and layout.
"""
