"""No link inside the pages of the shipped report is dead."""

import re
from functools import cache
from html import unescape
from urllib.parse import unquote

import pytest
from tests.copies import ROOT


@cache
def text_of(page) -> str:
    return page.read_text(encoding="utf-8")


@pytest.mark.parametrize("page", sorted((ROOT / "reports/validation").glob("*.html")), ids=lambda page: page.name)
def test_no_link_of_the_report_is_dead(page) -> None:
    text = re.sub(r"<script.*?</script>", "", text_of(page), flags=re.DOTALL)
    addresses = set(map(unescape, re.findall(r'(?:href|src)="([^"]*)"', text)))
    for address in (x for x in addresses if not re.match(r"[a-z]+:", x)):
        file, _, anchor = unquote(address).partition("#")
        target = page.parent / file if file else page
        assert target.exists(), address
        assert not anchor or target.suffix != ".html" or f' id="{anchor}"' in text_of(target), address
