#!/usr/bin/env python3
"""print_failures.py REPORT: of each test that failed, its name and the last lines that it printed (REPORT: JUnit XML of ctest)."""

import sys
import xml.etree.ElementTree

LINES = 40


def main() -> None:
    for case in xml.etree.ElementTree.parse(sys.argv[1]).getroot().iter("testcase"):
        if case.find("failure") is not None:
            printed = (case.findtext("system-out") or "").rstrip().splitlines()
            print(f"zoned: {case.get('name')} failed; its last lines:", *printed[-LINES:], sep="\n  ")


main()
