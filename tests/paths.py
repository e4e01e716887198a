"""Where the tests find what they read."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "samples"
NECK_FILE = SAMPLES / "recording/neck.yaml"
SHARED = ROOT.parent / "shared/data"
"""real pictures and foreign arms, on machines that have them"""
