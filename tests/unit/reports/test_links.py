"""No link inside the pages of the shipped report is dead."""

import re
from functools import cache
from html import unescape
from urllib.parse import unquote

import pytest
from tests.copies import ROOT

REPORT = ROOT / "reports/validation"


@cache
def ids(page) -> frozenset[str]:
    return frozenset(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8")))


def dead(page) -> list[str]:
    """Addresses in a page that lead nowhere."""
    text = re.sub(r"<script.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    found = []
    for address in set(map(unescape, re.findall(r'(?:href|src)="([^"]*)"', text))):
        if re.match(r"[a-z]+:", address):
            continue
        file, _, anchor = unquote(address).partition("#")
        target = page.parent / file if file else page
        if not target.exists() or (anchor and target.suffix == ".html" and anchor not in ids(target)):
            found.append(address)
    return sorted(found)


@pytest.mark.parametrize("page", sorted(REPORT.glob("*.html")), ids=lambda page: page.name)
def test_no_link_of_the_report_is_dead(page) -> None:
    assert not dead(page)
