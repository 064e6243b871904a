"""Numbers of a scene from measurements: what fits them, how sure that is, what they do to a result."""
