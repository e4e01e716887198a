"""Arms integrated forward under a controller, many at once: recording folders and their truth.

A second generator. It shares no code with `samples.generator` nor with any package of the project (numpy, scipy and yaml
only): what an estimator finds in its worlds is not owed to a formula of its own. Equations and signs are those of
docs/conventions.md.
"""

from samples.forward_arms.arms import Arm, make_arms
from samples.forward_arms.settings import Settings

__all__ = ["Arm", "Settings", "make_arms"]
