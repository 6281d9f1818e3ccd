"""The outcomes of replays as JUnit's XML, which continuous-integration servers read."""

from collections.abc import Sequence
from xml.etree import ElementTree as ET

from attest_mav.replay.limits import LogResult


def junit_xml(results: Sequence[LogResult]) -> bytes:
    """A suite for each log with a case for each limit; one case for the reading of the log."""
    root = ET.Element("testsuites", name="attest-mav replay")
    for result in results:
        missed = sum([not one.passes for one in result.checked])
        suite = ET.SubElement(
            root,
            "testsuite",
            name=_printable(result.log),
            tests=str(1 + len(result.checked)),
            failures=str(missed),
            errors=str(int(bool(result.error))),
        )
        read = _case(suite, "is read", result.log)
        if result.error:
            ET.SubElement(read, "error", message=_printable(result.error))
        for one in result.checked:
            case = _case(suite, f"{one.name} <= {one.limit:g}", result.log)
            if not one.passes:
                ET.SubElement(case, "failure", message=_printable(str(one)))
    ET.indent(root)
    xml: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return xml


def _case(suite: ET.Element, name: str, log: str) -> ET.Element:
    return ET.SubElement(suite, "testcase", name=name, classname=_printable(log))


def _printable(text: str) -> str:
    """The text without characters that XML cannot hold: controls, and bytes of a file name that are no text."""
    return "".join(one if one.isprintable() else "\N{REPLACEMENT CHARACTER}" for one in text)
