"""Refuse model descriptions with a document type, whose entities could expand without end."""

from __future__ import annotations

import io
from typing import Any
from xml.parsers import expat

from gmfbo.errors import FmuFileError

LARGEST_BYTES = 256 * 2**20  # the largest seen, of a vehicle model, has 30 MB


class _FirstElement(Exception):
    pass


class _DocumentType(Exception):
    pass


def check_prolog(name: str, content: bytes) -> None:
    """Raise if a model description has a document type: FMI has none, and entities are unsafe.

    Parameters
    ----------
    name : str
        File name of the FMU, for the message.
    content : bytes
        `modelDescription.xml`.

    Raises
    ------
    FmuFileError
        There is a document type, or the text is larger than any description.
    """
    if len(content) > LARGEST_BYTES:
        raise FmuFileError(
            f"'{name}' is refused: its modelDescription.xml has {len(content) / 1e6:.0f} MB, "
            f"expected at most {LARGEST_BYTES / 1e6:.0f} MB; ask its vendor for a smaller export"
        )
    if _has_document_type(content):
        raise FmuFileError(
            f"'{name}' is refused: its modelDescription.xml has a document type (<!DOCTYPE>), "
            "which FMI does not know and which can read files or fill the memory; get the FMU "
            "from a source you trust"
        )


def _has_document_type(content: bytes) -> bool:
    """Whether XML, perhaps damaged, declares a document type; no entity of it is expanded."""
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _document_type
    parser.StartElementHandler = _first_element
    try:
        parser.Parse(content, True)
    except _DocumentType:
        return True
    except _FirstElement:
        return False
    except (expat.ExpatError, ValueError, LookupError):
        # The reader of the description tolerates more than this parser, such as a wrong encoding.
        return _has_document_type_to_libxml2(content)
    return False


def _has_document_type_to_libxml2(content: bytes) -> bool:
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        tree = etree.parse(io.BytesIO(content), parser)
    except etree.XMLSyntaxError:
        return False  # the reader of the description will report the damage
    return tree.docinfo.internalDTD is not None or bool(tree.docinfo.doctype)


def _document_type(*_: Any) -> None:
    raise _DocumentType


def _first_element(*_: Any) -> None:
    raise _FirstElement
