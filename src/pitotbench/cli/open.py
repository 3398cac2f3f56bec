"""`pitotbench open`: a page in the browser on which one drops a log and sees the answer."""

import argparse
from importlib.util import find_spec
from pathlib import Path

from pitotbench.cli.shared_flags import flag
from pitotbench.records import BadInputError

_PORT = 5020  # of the page, where none is asked for
_LAST_PORT = 65_535  # that TCP has


FLAGS = (
    flag(
        "logs",
        nargs="*",
        type=Path,
        metavar="FILE",
        help="log files, folders or .zip files to begin with; others are dropped on the page",
    ),
    flag(
        "--port",
        type=int,
        default=_PORT,
        help="port on 127.0.0.1; where it is taken, the next one (default: %(default)s)",
    ),
    flag("--no-browser", action="store_true", help="print the address, and open no browser"),
)


def run(options: argparse.Namespace) -> int:
    """Serve the page until it is left; return exit code 0.

    Raises BadInputError for a file that is not there, a port that cannot be, and without Bokeh.
    """
    import webbrowser

    from pitotbench.show.columns import printable

    if find_spec("bokeh") is None:
        raise BadInputError("the page needs Bokeh: pip install 'pitotbench[open]'")
    if missing := [str(path) for path in options.logs if not path.exists()]:
        raise BadInputError(f"{missing[0]}: there is no such file or folder")
    if not 0 <= options.port <= _LAST_PORT:
        raise BadInputError(f"--port {options.port}: give 1024 to {_LAST_PORT}, or 0 for any")
    from pitotbench.browser.server import run_page

    run_page(
        options.logs,
        options.port,
        show=(lambda address: True) if options.no_browser else webbrowser.open,
        say=lambda line: print(printable(line), flush=True),
    )
    return 0
