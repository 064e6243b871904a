"""How many lanes batches have: few programs for short runs, few idle lanes for long ones."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from lumpedcable.study import batches, shards

SECONDS, MINUTES = 5e-3, 60.0  # what a lane takes (s)


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(batches.jax, "device_count", lambda: 2)
    monkeypatch.setattr(batches.jax, "default_backend", lambda: "cpu")


def sizes_for(counts, time, runs):
    return batches.sizes_for([(n, time) for n in counts], batches.batch_sizes(runs), runs)


def lanes(counts, time, runs):
    sizes = sizes_for(counts, time, runs)
    return [batches.lanes(n, sizes) for n in counts]


@pytest.mark.parametrize("runs", [1, 2, 3, 8, 37, 128, 1024])
@pytest.mark.parametrize("time", [SECONDS, MINUTES])
def test_runs_that_fit_into_batches_of_one_size_are_left_alone(runs, time):
    assert lanes([runs], time, runs) == [batches.lanes(runs, batches.batch_sizes(runs))]


def test_short_runs_are_filled_up_rather_than_compiled_for():
    assert lanes([165], SECONDS, 165) == [[128, 128]]
    assert lanes([165], MINUTES, 165) == [[128, 32, 4, 1]]


def test_a_few_groups_of_steps_share_a_size():
    assert len(sizes_for([5, 3, 4], SECONDS, 12)) == 1
    assert lanes([5, 3, 4], MINUTES, 12) == [[8], [4], [4]]


@pytest.mark.parametrize("counts", [[976], [24], [48, 500]])
def test_a_shard_takes_the_size_that_others_of_its_structure_take(counts):
    sizes = batches.batch_sizes(10_000)
    assert sizes == (32, 128)
    assert batches.sizes_for([(n, SECONDS) for n in counts], sizes, 1000.0) == (128,)


@pytest.mark.parametrize("devices", [1, 4])
def test_a_shard_on_gpus_is_one_batch(monkeypatch, devices):
    monkeypatch.setattr(batches.jax, "device_count", lambda: devices)
    monkeypatch.setattr(batches.jax, "default_backend", lambda: "gpu")
    shard, sizes = batches.kind().block, batches.batch_sizes(100_000, 101)
    assert sizes[-1] == shard * devices == 8192 * devices
    assert batches.lanes(shard, batches.sizes_for([(shard, SECONDS)], sizes, 1e5)) == [shard]
    assert batches.lanes(4 * shard, sizes) == [shard * devices] * (4 // devices)
    assert batches.batch_sizes(1) == tuple(2**k for k in range(12 + 2 * (devices > 1)))


def test_long_lines_have_fewer_lanes_on_a_gpu(monkeypatch):
    monkeypatch.setattr(batches.jax, "device_count", lambda: 1)
    monkeypatch.setattr(batches.jax, "default_backend", lambda: "gpu")
    assert batches.batch_sizes(100_000, 1000)[-1] == 1024
    assert batches.batch_sizes(100_000, 10**6)[-1] == 64
    monkeypatch.setattr(batches.jax, "default_backend", lambda: "cpu")
    assert batches.batch_sizes(100_000, 10**6)[-1] == 64


def test_what_is_asked_for_ten_thousand_times_is_compiled_for():
    groups, sizes = [(500, SECONDS), (540, SECONDS)], batches.batch_sizes(10**7)
    assert batches.sizes_for(groups, sizes, 1e3) == (128,)
    assert batches.sizes_for(groups, sizes, 1e7) == (32, 128)


@pytest.mark.parametrize("time", [1e-6, SECONDS, 1.0, MINUTES])
@pytest.mark.parametrize("counts", [[7, 9, 33], [130, 1], [64, 64, 2], [1] * 9, [300, 44]])
def test_no_choice_is_dearer_than_all_sizes(counts, time):
    runs = sum(counts)

    def cost(sizes):
        used = [size for n in counts for size in batches.lanes(n, sizes)]
        assert all(sum(batches.lanes(n, sizes)) >= n for n in counts)
        return batches.COMPILING * len(set(used)) + time * sum(s + batches.CPU.call for s in used)

    assert cost(sizes_for(counts, time, runs)) <= cost(batches.batch_sizes(runs)) * (1 + 1e-12)


@pytest.mark.parametrize("at_once", [1, 2, 3, 20])
@pytest.mark.parametrize("count", [0, 1, 2, 9, 10])
def test_shards_under_way_at_once_are_far_from_each_other(count, at_once):
    missing = list(range(0, 3 * count, 3))
    assert shards.apart(missing, study("a"), at_once) == missing
    order = shards.apart(missing, study("ab"), at_once)
    assert sorted(order) == missing
    if (count, at_once) == (10, 2):
        assert order[:4] == [0, 15, 3, 18]


@pytest.mark.parametrize("structures", ["a", "abc"])
@pytest.mark.parametrize("of", [1, 2, 3, 7, 20])
def test_shares_have_every_shard_once(structures, of):
    folder = cast(Any, SimpleNamespace(shards=13, missing=lambda: [0, 1, 2, 5, 6, 7, 8, 11, 12]))
    found = [shards.Share(k, of).missing(folder, study(structures)) for k in range(of)]
    assert sorted(s for mine in found for s in mine) == folder.missing()
    if of == 3:
        many = [[0, 1, 2], [5, 6, 7, 8], [11, 12]]
        assert found == (many if structures == "abc" else [[0, 6, 12], [1, 7], [2, 5, 8, 11]])


def study(structures):
    return cast(Any, SimpleNamespace(structures=structures))


@pytest.mark.parametrize(
    ("cores", "runs", "size"),
    [
        (1, 5, 64), (1, 512, 64), (1, 513, 128), (2, 1000, 128), (2, 1025, 256), (2, 8192, 1024),
        (2, 100_000, 1024), (16, 100, 1024), (64, 100, 1024),
    ],
)  # fmt: skip
def test_a_small_study_has_some_shards_too(monkeypatch, cores, runs, size):
    monkeypatch.setattr(batches.jax, "device_count", lambda: cores)
    assert batches.shard_size(runs) == size


def test_a_gpu_has_large_shards_alone(monkeypatch):
    monkeypatch.setattr(batches.jax, "default_backend", lambda: "gpu")
    assert [batches.shard_size(runs) for runs in (100, 100_000)] == [8192, 8192]
