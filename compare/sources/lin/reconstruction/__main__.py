"""``python -m rollbench.comparison.sources.lin.reconstruction``: compute the 3D runs that are missing, say what follows."""

from __future__ import annotations

from rollbench.comparison.commands.arguments.terminal import cache_folder
from rollbench.comparison.commands.printing import on_terminal
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.lin.reconstruction.runs import complete
from rollbench.comparison.sources.lin.sections.reconstruction import first_paragraph

complete(on_terminal, cache_folder())
print(first_paragraph(Study()))
