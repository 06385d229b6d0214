"""What the user is told and can mend."""


class Problem(Exception):
    """One sentence that says what is wrong and what to do."""
