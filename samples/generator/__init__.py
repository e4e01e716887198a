"""How the sample recordings were made: an arm, a controller, a camera and two clocks.

Nothing here imports the packages that are tested on what it makes: the arm moves by MuJoCo's closed loops, cables are
taut strings over circles, and pictures come from a renderer of their own.
"""
