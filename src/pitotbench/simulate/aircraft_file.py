"""Read the XML files of an aircraft."""

import xml.etree.ElementTree as ET
from pathlib import Path

from pitotbench.records.errors import BadInputError


def parse_xml(file: Path, comments: bool = False) -> "ET.ElementTree[ET.Element]":
    """Parse an XML file of an aircraft and return its tree; `comments` keeps the XML comments.

    Raises BadInputError for a file that is not XML; the message names the file and the line.
    """
    try:
        return ET.parse(file, ET.XMLParser(target=ET.TreeBuilder(insert_comments=comments)))
    except ET.ParseError as error:
        raise BadInputError(f"aircraft file {file}: not valid XML: {error}") from error
