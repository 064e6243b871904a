"""`python -m lumpedcable` is the command line."""

from lumpedcable.cli import main

main()
