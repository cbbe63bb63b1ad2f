"""The smallest set-up of the 3D reference, made once for the modules that look at it."""

import pytest
from tests.two_balls import SMALL, two_balls

from rollbench.hifi import setup
from rollbench.hifi.bodies import coarse
from rollbench.meshes.cache import Cache


@pytest.fixture(scope="session")
def small_cache(tmp_path_factory):
    return Cache(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="module")
def _one_submodel():
    """One mesh of each submodel: a mean over several changes no field and no balance."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coarse, "REALISATIONS", 1)
        yield


@pytest.fixture(scope="session")
def small(small_cache):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coarse, "REALISATIONS", 1)
        return setup.mesh_and_condense_geometry(two_balls(), (0, 3), SMALL, cache=small_cache)
