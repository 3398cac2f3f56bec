"""What a file is that is no log, by its suffix or its first line, and what its owner can do."""

import re
from collections.abc import Sequence

# Suffix: what it is, and the way to a log.
_KINDS = {
    ".xls .xlsm .ods .numbers": "a spreadsheet: save its sheet as CSV (UTF-8), and give that",
    ".tlog": "telemetry of MAVLink: give the log that the autopilot wrote itself (.bin, .ulg); it "
    "holds the sensors at their own rates",
    ".bbl .bfl": "a Blackbox recording: `blackbox_decode FILE` of blackbox-tools writes the CSV "
    "that is read",
    ".gpx .kml .kmz .tcx .fit .nmea": "a track of positions, without an airspeed: give the log of "
    "the box that shows the airspeed",
    ".json .json.gz": "a JSON file: write its values as a CSV table with a row a moment, and give "
    'that; of a list of rows Python does: pandas.read_json(FILE).to_csv("flight.csv", index=False)',
    ".7z .rar .tar .tgz .gz": "a packed file: unpack it, or pack it as .zip, and give that",
}
NOT_READ = {suffix: words for each, words in _KINDS.items() for suffix in each.split()}
_STREAM = re.compile(r"[!=][\w+.-]{20,}")  # a message of a display's serial port
_OF_STREAM = (
    "messages of a display's serial port, no table: give the log that the display itself records, "
    "with names above its columns (of a SkyView the user data log, of a G3X the log on its card)"
)
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*")


def headless(names: Sequence[str]) -> str:
    """Return what to do with a table without a line of names, or with a message; "" for others.

    Numbers alone stand in the first line of such a table.
    """
    if not names or not all(_NUMBER.fullmatch(name) for name in names):
        return _OF_STREAM if len(names) == 1 and _STREAM.fullmatch(names[0]) else ""
    channel = (
        "; a file of one channel is to be joined with the others of its flight, a column each"
        if len(names) < _FEWEST_OF_A_LOG
        else ""
    )
    return (
        "the table has no line of names: a number stands in its first line. Write a line of names "
        "with their units above it, such as time_s,indicated_airspeed_kt,pressure_altitude_ft,"
        f"ground_speed_kt,track_deg{channel}"
    )


_FEWEST_OF_A_LOG = 4  # columns: time, airspeed, and a velocity of two
