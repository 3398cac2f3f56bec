"""Run a measurement of the laboratory: `python scripts/lab.py NAME` is `python -m pitotlab NAME`.

python scripts/lab.py             # the names
"""

import sys

from this_checkout import run_measurement

if __name__ == "__main__":
    sys.exit(run_measurement())
