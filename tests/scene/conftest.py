import good_scenes
import pytest


@pytest.fixture
def rope(tmp_path):
    return good_scenes.write(tmp_path, good_scenes.ROPE)


@pytest.fixture
def bridle(tmp_path):
    return good_scenes.write(tmp_path, good_scenes.BRIDLE)
