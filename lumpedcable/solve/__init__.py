"""Solvers: static equilibrium, time integration, and the step that it may take."""
