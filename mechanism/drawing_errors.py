"""How well the numbers of a drawing are known, as relative standard deviations: one place for clocks and diagnosis.

A number that is off by up to 1 %, evenly, has a standard deviation of 0.6 %; what is turned on a lathe is five times better.
"""

DRAWING_SIGMA = 0.006
"""of lengths, masses, inertias and springs (docs/thresholds.md)"""
LATHE_SIGMA = 0.0012
"""of drums (docs/thresholds.md)"""
