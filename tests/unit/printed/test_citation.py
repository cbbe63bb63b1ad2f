"""CITATION.cff says the version that the package has and the authors of the licence."""

from tests.copies import ROOT

from rollbench.compare import __version__


def test_the_citation_is_of_this_version_and_its_authors():
    lines = dict(
        line.strip("- ").split(": ", 1) for line in (ROOT / "CITATION.cff").read_text().splitlines() if ": " in line
    )
    assert lines["version"] == __version__
    assert f"Copyright (c) 2026 {lines['name']}" in (ROOT / "LICENSE").read_text()
    assert lines["license"] == "MIT"
    assert f"\n## {__version__}\n" in (ROOT / "CHANGELOG.md").read_text()
