"""Independent simulators of the legged body, for tests and benchmarks only.

They share nothing with the package: one integrates with heyoka's Taylor series to the last bits of a double
(or beyond), the other with SciPy as a researcher would write it.
"""
