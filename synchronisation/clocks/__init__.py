"""The clock between camera and log. `clock.py` is the entry; the steps in their order:

log_gaps             repeated and missing rows of the log
coarse_alignment     the shift of best cross-correlation of cable speeds
exchanged_labels     signs, angles or columns that are exchanged; alternative_arms: arms mirrored or renumbered as a whole
fine_alignment       offset, skew and nuisances from cable_equation and arm_equation, by gauss_newton_fit
angles_between_frames  what joints do between the frames of a slow camera, for the arm's equation
lost_frame_alignment the fit together with lost_frames, decoded by Viterbi
winch_slips          cables that moved on their drums; slip_alignment tells them from lost frames
without_force        a rougher fit for logs that hold no forces
light                the clock of a light that the controller switches
"""
