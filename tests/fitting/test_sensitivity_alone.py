"""Differences beside derivatives come to the same by a program that has no derivatives."""

import logging

import jax
import numpy as np
import pytest
from engine_runs import HOOKE, study_of

from lumpedcable.fitting import sensitivity
from lumpedcable.fitting.scalar import read_scalar

TEXT = HOOKE.replace("segments = 50", "segments = 10") + '[solver]\nwaves = "plain"\n'


def test_slow_scenes_have_differences_by_a_program_of_their_own(tmp_path, monkeypatch):
    study = study_of(tmp_path, TEXT)
    scalar = read_scalar("last position at rope.end in x", study.runs[0])
    calls = []
    alone = sensitivity._alone

    def counted(*arguments):
        calls.append(arguments)
        return alone(*arguments)

    monkeypatch.setattr(sensitivity, "_alone", counted)
    usual = sensitivity.sensitivity_of(study, scalar)
    assert not calls
    monkeypatch.setattr(sensitivity, "SLOW", 0.0)
    slow = sensitivity.sensitivity_of(study, scalar)
    assert len(calls) == 2 * len(slow.check.steps)
    assert slow.check.key == usual.check.key
    np.testing.assert_allclose(slow.check.differences, usual.check.differences, rtol=1e-9)
    assert slow.check.share == pytest.approx(usual.check.share, rel=1e-12)


def test_what_starts_a_run_is_compiled_once(tmp_path, monkeypatch, caplog):
    study = study_of(tmp_path, TEXT.replace("segments = 10", "segments = 7"))
    scalar = read_scalar("last position at rope.end in x", study.runs[0])
    monkeypatch.setattr(sensitivity, "SLOW", 0.0)
    with jax.log_compiles(), caplog.at_level(logging.WARNING):
        sensitivity.sensitivity_of(study, scalar)
    compiled = [text for text in caplog.messages if "Finished XLA compilation" in text]
    assert sum("started" in text for text in compiled) == 1
