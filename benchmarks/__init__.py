"""Speed against error: problems with known answers, methods, peers, and one report.

Run with `python -m benchmarks`. Nothing here is part of the installed package.
"""
