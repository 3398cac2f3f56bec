"""What the exit code of a command means."""

DONE = 0
UNFORESEEN = 1  # an error that no rule of the bench explains, or a reader that closed the pipe
BAD_INPUT = 2  # as argparse has it
NO_ANSWER = 3  # not converged, not observable, or flights lost
INTERRUPTED = 130  # as shells have it: 128 and the number of SIGINT
