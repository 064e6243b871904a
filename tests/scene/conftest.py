import good_scenes
import pytest

from lumpedcable.scene import Scene


@pytest.fixture
def rope(tmp_path):
    return good_scenes.write(tmp_path, good_scenes.ROPE)


@pytest.fixture
def bridle(tmp_path):
    return good_scenes.write(tmp_path, good_scenes.BRIDLE)


@pytest.fixture
def scenes_built(monkeypatch):
    """How many scenes have been made, as a list of one number."""
    count = [0]

    def counted(make):
        def build(*args, **kwargs):
            count[0] += 1
            return make(*args, **kwargs)

        return build

    for name in ("model_validate", "with_numbers"):
        monkeypatch.setattr(Scene, name, counted(getattr(Scene, name)))
    return count
