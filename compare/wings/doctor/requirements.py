"""``rollbench doctor --requirements COMMAND``: the pinned lines that a command needs, for a small environment."""

from __future__ import annotations

import re
from importlib import metadata

from rollbench.comparison import __version__
from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.errors import InputError
from rollbench.comparison.wings.doctor.command import requirements
from rollbench.meshes.libraries import EXTRAS, NEEDED_BY, ONLY_FOR, PAGES, version


def run_requirements(command: str) -> Answer:
    """Lines ``name==version`` of all packages that a command of `NEEDED_BY` needs here, those that they need among them;
    what goes without the rest as comments. Raises InputError where one is not installed."""
    direct = requirements()
    if not direct:
        advice = "pip install . installs it, and its metadata say what it needs"
        raise InputError("doctor", "--requirements", command, "an installed rollbench", advice)
    apart = {*ONLY_FOR, *PAGES}
    named = [*direct, *EXTRAS] if command in ("report", "all") else [*(set(direct) - apart), *NEEDED_BY[command]]
    lines = sorted(f"{name}=={pinned}" for name, pinned in closure(named).items())
    without = [name for name in ONLY_FOR if name not in named]
    heads = [
        f"# what {command} needs of packages, as installed here by rollbench {__version__}; then:",
        "# pip install --no-deps -r THIS_FILE, and the same with the folder, wheel or git address of rollbench",
        *(f"# without {name}: {ONLY_FOR[name]}" for name in without),
    ]
    return Answer({"command": command, "requirements": lines, "without": without}, [*heads, *lines])


def closure(names: list[str]) -> dict[str, str]:
    """Versions of installed packages and of all that they need, by normalised name; what an extra of theirs asks for, and
    what is not installed because it is for other machines, is left out. Raises InputError where one of ``names`` lacks."""
    versions: dict[str, str] = {}
    left = [(name, True) for name in names]
    while left:
        name, asked = left.pop()
        name = re.sub(r"[-_.]+", "-", name).lower()
        installed = version(name)
        if installed is None and asked:
            advice = "pip install 'rollbench[report]' installs all, or: pip install " + name
            raise InputError("doctor", "--requirements", f"{name} is not installed", "a package that is installed", advice)
        if installed is None or name in versions:
            continue
        versions[name] = installed
        needs = [line for line in metadata.requires(name) or () if "extra ==" not in line.replace("extra==", "extra ==")]
        left += [(re.split(r"[^\w.-]", line, maxsplit=1)[0], False) for line in needs]
    return versions
