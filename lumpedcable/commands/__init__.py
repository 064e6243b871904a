"""Commands in files of their own, and what all commands share; `cli.py` puts them together."""
