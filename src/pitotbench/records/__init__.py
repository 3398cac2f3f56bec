"""The records that packages exchange, and the two errors of the bench, which state the rule and what to do."""


# The two errors of the bench. Each message states the rule and what to do.


class BadInputError(ValueError):
    """The input cannot be used. The command line ends with exit code 2."""


class NoAnswerError(RuntimeError):
    """The input is valid but does not determine an answer: not observable, or not converged. Exit code 3."""
