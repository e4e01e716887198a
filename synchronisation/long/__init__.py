"""Synchronisation of recordings that are too long to be held in memory at once, part by part."""
