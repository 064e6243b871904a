"""Runs of a scene: a sweep as one batch on the device, streamed to a file, summed up in a table."""
