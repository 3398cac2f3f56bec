"""The XML files of an aircraft."""

import xml.etree.ElementTree as ET
from pathlib import Path

from pitotbench.records.errors import BadInputError


def parse_xml(file: Path, comments: bool = False) -> "ET.ElementTree[ET.Element]":
    """The tree of an aircraft's file, with its comments where asked for.

    Raises BadInputError, which names the file and the place, for a file that is not XML.
    """
    try:
        return ET.parse(file, ET.XMLParser(target=ET.TreeBuilder(insert_comments=comments)))
    except ET.ParseError as error:
        raise BadInputError(f"aircraft file {file}: not valid XML: {error}") from error
