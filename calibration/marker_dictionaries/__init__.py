"""Marker dictionaries of one's own, one YAML file each (docs/new-dictionary.md); the file's name is the dictionary's."""
