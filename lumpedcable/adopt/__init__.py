"""Scenes from other programs' input files."""
