"""How well clocks take the numbers of a drawing to be known, relative to themselves."""

MAX_DRAWING_ERROR = 0.01
"""of lengths, masses, inertias of bars and springs: they are off by anything up to this. A clock takes it for a standard
deviation, so that it does not lean on a drawing: with less, arms in slow motion whose signs are all turned are no longer noticed
(docs/thresholds.md)"""
MOTOR_INERTIA_SIGMA = 0.1
"""of each motor's inertia, one standard deviation: data sheets leave out what else turns with the shaft (docs/thresholds.md)"""
