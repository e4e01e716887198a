"""Figures of README and docs: taken from records of real runs and written into the pages' placeholders."""
