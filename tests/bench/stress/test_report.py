"""The report of the trials, and the command."""

import json

import numpy as np
import pytest

from vr_envs.__main__ import main
from vr_envs.bench.stress import trials
from vr_envs.bench.stress.trial import Failure, Outcome, Trial, attempt


def half_broken(first, number, trace):
    """Cases that fail from number 4 on; a step takes as many us as the case's number."""
    outcome = Outcome()
    for seed in range(first, first + number):
        failures = [Failure(seed, "it broke, at step 2")] if seed >= 4 else []
        times = np.zeros_like(Outcome().times)
        times[100] = 10
        trace[:1] = 1e-6 * seed
        outcome.add(Outcome(10, failures, 0.1 * seed, seed, [(1e-6 * seed, seed)], times, told=1))
    return outcome


@pytest.fixture
def toy(monkeypatch):
    trial = Trial("toy", "none", "nothing", "steps", "depth", 6, half_broken, "given up")
    monkeypatch.setitem(trials.TRIALS, "toy", trial)
    return trial


def test_every_failure_is_told_with_its_seed_and_the_command_that_repeats_it(toy, tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["bench", "stress", "--trial", "toy", "--out", str(tmp_path)])
    assert left.value.code == 1
    out = capsys.readouterr().out
    for seed in (4, 5):
        assert f"vr-envs bench stress --trial toy --seed {seed}" in out
    assert "2 failures" in out and "it broke, at step 2" in out and "60 steps in 6 cases" in out
    found = json.loads((tmp_path / "stress.json").read_text())["numbers"]["toy"]
    assert [failure["seed"] for failure in found["failures"]] == [4, 5]
    assert (found["count"], found["told"], found["worst_seed"], found["slowest_again_seed"]) == (60, 6, 5, 5)
    assert found["slowest_us"] == found["slowest_again_us"] == pytest.approx(5.0)
    assert (tmp_path / "stress-time.png").exists() and not (tmp_path / "stress-passage.png").exists()


def test_one_case_is_repeated_alone(toy, tmp_path, capsys):
    assert main(["bench", "stress", "--trial", "toy", "--seed", "3", "--out", str(tmp_path)]) == 0
    assert "10 steps in 1 case" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["bench", "stress", "--trial", "toy", "--seed", "4", "--out", str(tmp_path)])
    assert "--seed 4" in capsys.readouterr().out


def test_an_error_is_a_failure_of_its_case():
    def run(first, number, trace):
        if first <= 4 < first + number:
            raise ZeroDivisionError("so it is")
        return Outcome(number, worst=1.0, worst_seed=first)

    outcome, _ = attempt(Trial("toy", "none", "nothing", "steps", "depth", 6, run), 0, 6)
    assert outcome.failures == [Failure(4, "ZeroDivisionError: so it is")] and outcome.count == 5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--trial", "nothing"], "there is no trial 'nothing'; choose one of"),
        (["--seed", "3"], "name it with --trial"),
    ],
)
def test_bad_arguments_are_refused_in_words(arguments, message, tmp_path, capsys):
    assert main(["bench", "stress", *arguments, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err
