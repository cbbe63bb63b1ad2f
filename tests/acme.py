"""A case that another publication would add: what is printed, how it is computed, its page."""

FILES = {
    "__init__.py": "",
    "printed/acme-1.toml": """
title = "Contact modulus of steel on steel, balls of a screw"
source = "Acme (1901)"
place = "Table 1"
[[row]]
key = "modulus"
label = "contact modulus"
printed = "113.9"
unit = "GPa"
class = "hard"
verdict = "reproduced"
[[row]]
key = "balls"
label = "balls"
printed = "2"
unit = ""
class = "hard"
verdict = "reproduced"
""",
    "computations.toml": """
["acme-1"]
function = "evidence:table_1"
test = "tests/sources/acme/literature/test_acme.py"
behind = { "modulus" = "one contact, in closed form", "balls" = ["acme-two-balls"] }
""",
    "evidence.py": '''
from rollbench.lowfi.hertz import contact_modulus
def table_1(findings, cache):
    """Table 1."""
    findings.add_number("modulus", 1e-9 * contact_modulus(210e9, 0.28, 210e9, 0.28))
    balls = len(cache.solve_once("acme-two-balls").load)
    findings.add_number("balls", float(balls))
''',
    "page.py": '''
from rollbench.compare.evidence import evidence
from rollbench.compare.sections.verdicts import printed_numbers_table
from rollbench.reports.content import Section
def make_section(cache, step):
    """Section of the report."""
    return Section("acme", "Acme (1901)", (printed_numbers_table("acme-1", "Table 1", evidence(cache, "acme-1")),))
''',
}


def write(folder, scene):
    """The package in a folder, with the text of its scene."""
    for name, text in (FILES | {"scenes/acme-two-balls.toml": scene}).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
