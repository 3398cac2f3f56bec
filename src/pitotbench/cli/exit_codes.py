"""What the exit code of a command means."""

DONE = 0
UNFORESEEN = 1  # an unexpected error, or a reader that closed the pipe
BAD_INPUT = 2  # the code of argparse for a wrong flag
NO_ANSWER = 3  # not converged, not observable, or flights lost
INTERRUPTED = 130  # the convention of shells: 128 plus the number of SIGINT
