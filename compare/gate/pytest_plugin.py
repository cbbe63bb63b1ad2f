"""Fixture for users' pytest that judges scenes against their 3D reference (`rollbench.fixture`)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.verdict import Verdict


class Rollbench:
    """Value of the pytest fixture ``rollbench``: judges scenes with paths relative to the test file.

    Parameters
    ----------
    root
        Folder from which paths start: that of the test file.
    """

    def __init__(self, root: Path) -> None:
        """Store the folder; the program is imported only when a scene is judged."""
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
        """Judge a scene, and fail the test unless it passes.

        A scene that is undecided or not covered fails too, and so does bad input.

        Parameters
        ----------
        scene
            File, from the folder of the test, or name of a shipped scene.
        max_error, model, loads, values, limits, reference, strict, levels, store, compute
            As for `rollbench.check`; paths start from the folder of the test.
        stored
            Folder of stored runs, used in addition to the shipped runs; none is computed.

        Returns
        -------
        list of Verdict
            The verdicts.
        """
        from rollbench.compare.errors import InputError
        from rollbench.compare.gate.user import check_scenes, gate_request
        from rollbench.compare.reference.jobs import Engine
        from rollbench.compare.scenes import catalogue
        from rollbench.meshes.cache import default_root

        try:
            request = gate_request(
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
