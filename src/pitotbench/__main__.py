"""`python -m pitotbench`: the command line."""

import sys

from pitotbench.cli.app import main

if __name__ == "__main__":
    sys.exit(main())
