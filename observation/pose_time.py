"""For how long the pose's error lasts."""

POSE_TIME_S = 1.0
"""s (docs/thresholds.md)"""
