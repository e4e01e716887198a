"""How well clocks take the numbers of a drawing to be known, relative to themselves."""

MAX_DRAWING_ERROR = 0.01
"""of lengths, masses and inertias of bars: they are off by anything up to this. A clock takes it for a standard
deviation, so that it does not lean on a drawing: with less, arms in slow motion whose signs are all turned are no longer noticed
(docs/thresholds.md)"""
MOTOR_INERTIA_SIGMA = 0.1
"""of each motor's inertia, one standard deviation: data sheets leave out what else turns with the shaft (docs/thresholds.md)"""
SPRING_STIFFNESS_SIGMA = 0.05
"""of each spring by itself, one standard deviation: the left one is not like the right one (docs/thresholds.md)"""
SPRING_LENGTH_SIGMA = 0.01
"""of each spring's free length by itself, one standard deviation (docs/thresholds.md)"""
ANGLE_ZERO_SIGMA_RAD = 0.01
"""rad: markers are stuck to the bars by hand, each bar's a little turned (docs/thresholds.md)"""
