"""The default method once more, in C: what the machine can do, and a second opinion on the result."""
