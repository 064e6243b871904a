"""One law per file: tension, weight, water, seabed, bending, release waves, ramps, motions.

Nothing here knows about lines as a whole, solvers or files: a law is a function of one segment or
one node, vectorised over all of them.
"""
