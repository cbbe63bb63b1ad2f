"""The folder of the project, and tests that need the last report in it."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
#: Of tests that read the last report, which a source archive leaves out.
of_report = pytest.mark.skipif(not (ROOT / "reports/validation").is_dir(), reason="no report in a source archive")
