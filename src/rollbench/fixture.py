"""Pytest plug-in of rollbench, whose fixture ``rollbench`` judges scenes against their 3D reference inside tests."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.verdict import VerdictRow


class RollbenchFixture:
    """Value of the pytest fixture ``rollbench``, by which a user's test judges a scene against its 3D reference.

    Parameters
    ----------
    test_folder
        Folder of the test file, to which paths are relative.
    """

    def __init__(self, test_folder: Path) -> None:
        """Store the folder of the test file."""
        self.root = test_folder

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
    ) -> list[VerdictRow]:
        """Judge a scene as ``rollbench check`` does, and fail the test unless every verdict is "pass".

        The test also fails if a verdict is "undecided" or "not covered", and if an argument or a file is not valid.

        Parameters
        ----------
        scene
            Path of a scene file, relative to the folder of the test file, or name of a shipped scene.
        max_error, model, loads, values, limits, reference, strict, levels, store, compute
            As for `rollbench.check`; paths are relative to the folder of the test file.
        stored
            Folder with stored runs of the 3D reference, used in addition to the shipped runs, instead of ``store``. If it
            is given, no new run is computed.

        Returns
        -------
        list of VerdictRow
            Verdicts on the scene, all "pass".
        """
        from rollbench.compare.errors import InputError
        from rollbench.compare.gate.user import GateRequest, check_scenes
        from rollbench.compare.reference.jobs import ComputingSettings
        from rollbench.compare.scenes import catalogue
        from rollbench.meshes.cache import default_cache_folder

        try:
            request = GateRequest(
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
            engine = ComputingSettings(cache_folder=default_cache_folder())
            verdicts = check_scenes([catalogue.scene(path)], request, engine, lambda _: None)
        except InputError as error:
            pytest.fail(str(error), pytrace=False)
        bad = [v.line for v in verdicts if not v]
        if bad:
            pytest.fail("\n".join(bad), pytrace=False)
        return verdicts


@pytest.fixture
def rollbench(request: pytest.FixtureRequest) -> RollbenchFixture:
    """Return an object whose method ``check`` judges a scene: ``rollbench.check("my.toml", max_error=7)``.

    Paths of scene files are relative to the test file.
    """
    return RollbenchFixture(request.path.parent)
