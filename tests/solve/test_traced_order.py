"""A program is traced in the scene's order in every process, so that kept ones are found again."""

from types import SimpleNamespace

from lumpedcable.model.bodies import body_key
from lumpedcable.solve import constrained


def test_bodies_on_no_rod_are_kicked_in_the_order_of_the_model(monkeypatch):
    # of a set, eight names come in this order once in 40320 times
    names = [f"buoy {word}" for word in ("west", "north", "one", "b", "east", "a", "two", "c")]
    seen = []

    def gain(model, name, *rest):
        seen.append(name)
        return SimpleNamespace(gain=2.0)

    monkeypatch.setattr(constrained, "paths_of", lambda model: [])
    monkeypatch.setattr(constrained, "body_gain", gain)
    monkeypatch.setattr(constrained, "follow_rate", lambda model, t, place, rate, *ahead: rate)
    monkeypatch.setattr(constrained, "evaluate", lambda *arguments: {})
    model = SimpleNamespace(bodies=dict.fromkeys(names))
    before = {body_key(name): 1.0 for name in names}
    found = constrained.kick(model, 0.0, {}, before, None, 0.5, 0.5)
    assert seen == names
    # v + a dt at the end, v + a dt / 2 in the middle
    assert list(found.after.items()) == [(body_key(name), 2.0) for name in names]
    assert list(found.middle.values()) == [1.5] * len(names)
