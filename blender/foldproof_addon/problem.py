"""Errors that the user can fix."""


class Problem(Exception):
    """One sentence that says what is wrong and what to do."""
