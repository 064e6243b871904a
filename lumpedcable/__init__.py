"""lumpedcable: cable dynamics for violent, short, nonlinear events.

A vectorised lumped-mass engine on JAX, integrated by diffrax and checked against exact answers.
Importing this package is cheap: jax is loaded only by the parts that compute.
"""

__version__ = "0.1.0"
__all__ = ["__version__"]
