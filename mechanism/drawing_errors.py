"""How well the numbers of a drawing are known, relative to themselves: one place for clocks and diagnosis."""

MAX_DRAWING_ERROR = 0.01
"""of lengths, masses, inertias and springs: they are off by anything up to this. A clock takes it for a standard deviation, so
that it does not lean on a drawing: with less, arms in slow motion whose signs are all turned are no longer noticed
(docs/thresholds.md)"""
DRAWING_SIGMA = 0.006
"""standard deviation of such an error, MAX_DRAWING_ERROR over the root of three (docs/thresholds.md)"""
LATHE_SIGMA = 0.0012
"""standard deviation of what is turned on a lathe, five times better: drums (docs/thresholds.md)"""
