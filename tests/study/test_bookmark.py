"""A run that was interrupted goes on from where it was, and ends as one that was not: bit for bit."""

import time
from unittest import mock

import h5py
import pytest
from command_line import python, say
from engine_runs import ROPE, nylon_rope, sliding_block, study_of
from file_contents import assert_equal_bits, contents

from lumpedcable import cli
from lumpedcable.commands import console
from lumpedcable.results.schema import partial_of
from lumpedcable.scene import load_study
from lumpedcable.status import Status
from lumpedcable.study import batches, bookmark, report, run, shrinking
from lumpedcable.study.bookmark import bookmark_of
from lumpedcable.study.run import run_study

# a rope that hangs slack until its end is pulled taut, and parts where it carries 60 kN
PULLED = (
    nylon_rope(10, "400 ms", "10 ms")
    .replace(
        'end = { held = { pretension = "45 kN", direction = [1, 0, 0] } }',
        'end = { motion = { position = [60, 0, 0], velocity = ["20 m/s", 0, 0] } }',
    )
    .replace('time = "5 ms"', 'time = "5 ms"\ntension = "60 kN"')
)
SWEEP = """
[sweep]
"lines.rope.end.held.pretension" = ["45 kN", "100 kN", "180 kN", "315 kN"]
"""


# eight blocks that slide to a stop, one after the other
STOPPED = sliding_block(
    speed=1, step="2 ms", duration="1.2 s", every="40 ms",
    more="""stop = "block"
[sweep]
"bodies.block.velocity.0" = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 3, 4]
""",
)  # fmt: skip
# the command with a note after every output
START = """
from lumpedcable import cli
from lumpedcable.study import batches, bookmark, run
bookmark.EVERY = bookmark.PRICE = run.PACE = 0.0
batches.CPU = batches.CPU._replace(first=1)
cli.main()
"""


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Notes are made after every piece, and pieces are of two outputs."""
    monkeypatch.setattr(bookmark, "EVERY", 0.0)
    monkeypatch.setattr(bookmark, "PRICE", 0)
    monkeypatch.setattr(run, "PACE", 0.0)
    monkeypatch.setattr(batches, "CPU", batches.CPU._replace(first=2))


def interrupted(study, target, share):
    """Run until a share of the outputs is done, as Ctrl-C would find it."""

    def show(done, total):
        if done >= share * total:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(study, target, show)


def gone_on(study, target):
    """What progress tells after the first word, and how often it was said that a run goes on."""
    told, said = [], []
    outcomes = run_study(
        study, target, lambda done, _: told.append(done), None, lambda: said.append(1)
    )
    return outcomes, told, len(said)


@pytest.mark.parametrize(
    ("text", "changes", "share"),
    [
        pytest.param(ROPE, (), 0.4, id="one"),
        pytest.param(ROPE, (), 1.0, id="after the last output"),
        pytest.param(ROPE, ("output.keep=summaries",), 0.4, id="summaries", marks=pytest.mark.slow),
        pytest.param(
            ROPE,
            ("output.keep=histories", "solver.dtype=float32"),
            0.4,
            id="float32",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ROPE,
            ("output.fields_every=4 ms",),
            0.55,
            id="fields now and then",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ROPE, ("solver.method=tsit5",), 0.4, id="steps of its own", marks=pytest.mark.slow
        ),
        pytest.param(PULLED, (), 0.9, id="a tension that was reached", marks=pytest.mark.slow),
        pytest.param(PULLED, (), 0.1, id="a tension that is still to come", marks=pytest.mark.slow),
        # the last run needs shorter steps than the others, so that it is a part of its own
        pytest.param(ROPE + SWEEP, (), 0.3, id="the first part", marks=pytest.mark.slow),
        pytest.param(ROPE + SWEEP, (), 0.9, id="the last part"),
    ],
)
def test_it_ends_as_if_nothing_had_been(tmp_path, text, changes, share):
    study, target = study_of(tmp_path, text, *changes), tmp_path / "cut.h5"
    whole = run_study(study, tmp_path / "whole.h5")
    interrupted(study, target, share)
    assert bookmark_of(target).exists()
    outcomes, told, said = gone_on(study, target)
    assert said == 1
    assert told[0] == 0
    # a piece was lost at most: the one whose end nobody had noted
    total = told[-1]
    assert min(done for done in told if done) >= (share - 0.2) * total
    assert_equal_bits(contents(tmp_path / "whole.h5"), contents(target))
    assert [o.status for o in outcomes] == [o.status for o in whole]
    assert [o.message for o in outcomes] == [o.message for o in whole]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cut.h5", "scene.toml", "whole.h5"]


def test_what_was_there_is_told_after_compiling(tmp_path, monkeypatch):
    """With the first piece of what was not, so that a rate tells of nothing but pieces."""
    study, target = study_of(tmp_path, ROPE + SWEEP), tmp_path / "cut.h5"
    interrupted(study, target, 0.9)
    told, before = [], []
    plainly = shrinking.Batch.advance
    monkeypatch.setattr(
        shrinking.Batch,
        "advance",
        lambda batch, *given: (before.append(max(told)), plainly(batch, *given))[1],
    )
    run_study(study, target, lambda done, _: told.append(done), None, lambda: None)
    assert before[0] == 0
    assert before[1] > 0.7 * told[-1]


def test_blocks_that_had_ended_are_not_run_again(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "kind", lambda: batches.CPU._replace(block=1, first=2))
    study, target = study_of(tmp_path, ROPE + SWEEP), tmp_path / "cut.h5"
    run_study(study, tmp_path / "whole.h5")
    interrupted(study, target, 0.6)
    begun = []
    plainly = run.starts
    monkeypatch.setattr(run, "starts", lambda *given: (begun.append(1), plainly(*given))[1])
    gone_on(study, target)
    assert len(begun) == 2  # of four runs one by one, the first two had ended
    assert_equal_bits(contents(tmp_path / "whole.h5"), contents(target))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.8, 0.9])
def test_runs_that_gave_up_lanes_go_on_without_them(tmp_path, monkeypatch, share):
    monkeypatch.setattr(shrinking, "COMPILING", 0.0)
    looks, plainly = [], shrinking.Batch.shrink
    monkeypatch.setattr(
        shrinking.Batch, "shrink", lambda b, n: (plainly(b, n), looks.append((n, b.size)))[0]
    )
    study, target = study_of(tmp_path, STOPPED), tmp_path / "cut.h5"
    run_study(study, tmp_path / "whole.h5")
    looks.clear()
    interrupted(study, target, share)
    assert looks[-1][1] < looks[0][1]
    _, told, said = gone_on(study, target)
    assert said == 1
    # a piece was lost at most
    assert min(done for done in told if done) >= (share - 0.2) * told[-1]
    assert_equal_bits(contents(tmp_path / "whole.h5"), contents(target))


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda target: bookmark_of(target).unlink(), id="no note"),
        pytest.param(lambda target: cut_short(bookmark_of(target)), id="half a note"),
        pytest.param(lambda target: bookmark_of(target).write_text("no"), id="no note at all"),
        pytest.param(lambda target: partial_of(target).unlink(), id="no file"),
        pytest.param(lambda target: cut_short(partial_of(target)), id="half a file"),
        pytest.param(lambda target: made_later(partial_of(target)), id="another file"),
    ],
)
def test_what_does_not_belong_together_is_begun_anew(tmp_path, change):
    study, target = study_of(tmp_path, ROPE), tmp_path / "cut.h5"
    interrupted(study, target, 0.5)
    change(target)
    outcomes, told, said = gone_on(study, target)
    assert said == 0
    assert min(done for done in told if done) < told[-1] / 4
    assert outcomes[0].status is Status.OK
    assert not bookmark_of(target).exists()


def cut_short(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def made_later(path):
    with h5py.File(path, "r+") as file:
        file.attrs["created"] = "2100-01-01T00:00:00+00:00"


@pytest.mark.parametrize("what", ["scene", "program", "versions"])
def test_another_scene_or_program_begins_anew(tmp_path, monkeypatch, what):
    study, target = study_of(tmp_path, ROPE), tmp_path / "cut.h5"
    interrupted(study, target, 0.5)
    if what == "scene":
        study = study_of(tmp_path, ROPE, "mass=3")
    elif what == "program":
        monkeypatch.setattr(bookmark, "SOURCES", "0" * 32)
    else:
        monkeypatch.setattr(bookmark, "versions", lambda: {"jax": "0"})
    outcomes, _, said = gone_on(study, target)
    assert said == 0
    assert outcomes[0].status is Status.OK


def test_a_disk_without_room_for_notes_ends_no_run(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bookmark.np, "savez", full)
    study, target = study_of(tmp_path, ROPE), tmp_path / "r.h5"
    (outcome,) = run_study(study, target)
    assert outcome.status is Status.OK
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r.h5", "scene.toml"]


@pytest.mark.slow
def test_a_command_that_was_killed_goes_on(tmp_path):
    (tmp_path / "rope.toml").write_text(nylon_rope(100, "120 ms"))  # ROPE, for longer
    command = ["-c", START, "run", "rope.toml", "-o", "cut.h5"]
    deadline = time.monotonic() + 120
    with python(*command, cwd=tmp_path) as child:
        while not bookmark_of(tmp_path / "cut.h5").exists():
            assert child.poll() is None, child.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.001)
        child.kill()
    with python(*command, cwd=tmp_path) as child:
        _, err = child.communicate(timeout=300)
    assert child.returncode == 0, err
    assert err == "rope.toml: goes on with cut.h5.partial\n"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cut.h5", "rope.toml"]
    run_study(load_study(tmp_path / "rope.toml"), tmp_path / "whole.h5")
    assert_equal_bits(contents(tmp_path / "whole.h5"), contents(tmp_path / "cut.h5"))


def test_an_interrupted_command_says_that_it_goes_on(tmp_path, monkeypatch):
    (tmp_path / "rope.toml").write_text(ROPE)
    done = []

    def stop(study, target, show, *_):
        return run_study(study, target, lambda now, total: (done.append(now), show(now, total)))

    monkeypatch.setattr(report, "run_study", stop)
    monkeypatch.setattr(cli, "stopped", lambda: any(now > 5 for now in done))
    with (
        mock.patch.object(console.atexit, "register"),
    ):
        said = say(tmp_path, "run", "rope.toml")
    told = "what was finished is in rope.h5.partial; the same command goes on with it"
    assert said == (130, "", f"interrupted; {told}\n")
