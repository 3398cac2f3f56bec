"""The two ways in which the bench says no; each message states the rule of the domain and the way out."""


class BadInputError(ValueError):
    """What was given cannot be used: exit code 2."""


class NoAnswerError(RuntimeError):
    """The input is sound but does not determine an answer (not observable, not converged): exit code 3."""
