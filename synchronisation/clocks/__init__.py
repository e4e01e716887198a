"""The clock between camera and log. `clock.py` is the entry; the steps in their order:

log_gaps             repeated and missing rows of the log
coarse_alignment     the shift of best cross-correlation of cable speeds
exchanged_labels     signs, angles or columns that are exchanged; alternative_arms: arms mirrored or renumbered as a whole
winch_slips          cables that moved on their drums
fine_alignment       offset, skew and nuisances from cable_equation and arm_equation, by gauss_newton_fit
lost_frame_alignment the fit together with lost_frames, decoded by Viterbi
without_force        a rougher fit for logs that hold no forces
light                the clock of a light that the controller switches
"""
