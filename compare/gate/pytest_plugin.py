"""Scenes judged against their 3D reference within a user's pytest (the fixture: `rollbench.fixture`)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.verdict import Verdict


class Rollbench:
    """What the fixture gives. ``root``: folder that paths start from, that of the test's own file."""

    def __init__(self, root: Path) -> None:
        """Keep the folder; nothing is imported before it is needed."""
        self.root = root

    def check(
        self,
        scene: str | Path,
        *,
        max_error: float | None = None,
        model: str = "",
        loads: str | Path | None = None,
        values: str | Path | None = None,
        limits: Mapping[str, float] | None = None,
        reference: str | Path | None = None,
        strict: bool = False,
        levels: int | None = None,
        stored: str | Path | None = None,
        store: str | Path = "rollbench-reference",
        compute: bool = True,
    ) -> list[Verdict]:
        """Fail the test unless the scene passes; returns the verdicts.

        scene: a file, from the folder of the test, or the name of a shipped scene; the rest as for ``rollbench check``.
        A scene that is undecided or not covered fails too: nothing is said of it. Bad input fails with its one line.
        """
        from rollbench.compare.errors import InputError
        from rollbench.compare.gate.user import asked, check_scenes
        from rollbench.compare.reference.jobs import Engine
        from rollbench.compare.scenes import catalogue
        from rollbench.meshes.cache import default_root

        try:
            request = asked(
                model=model,
                loads=None if loads is None else self.root / loads,
                values=None if values is None else self.root / values,
                max_error=max_error,
                limits=[f"{name}={number}" for name, number in (limits or {}).items()],
                reference=None if reference is None else self.root / reference,
                strict=strict,
                levels=levels,
                store=self.root / store,
                stored=None if stored is None else self.root / stored,
                compute=compute,
            )
            name = str(scene)
            path = name if name in catalogue.scene_names() else str(self.root / scene)
            verdicts = check_scenes([catalogue.scene(path)], request, Engine(cache=default_root()), lambda _: None)
        except InputError as error:
            pytest.fail(str(error), pytrace=False)
        bad = [v.line() for v in verdicts if v.word != "pass"]
        if bad:
            pytest.fail("\n".join(bad), pytrace=False)
        return verdicts
