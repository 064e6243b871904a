"""Errors of the results file, each with a one-line message meant for the user."""


class OutputError(Exception):
    """The results cannot be written where they were asked for; the message says where and why."""


class ResultError(Exception):
    """A file cannot be read as a result, or lacks what was asked of it; the message says why."""
