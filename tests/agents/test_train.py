import json
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file

from agents import __main__ as command
from agents import curve
from agents.config import from_mapping, load
from agents.learn import Clock
from agents.policy import TrainedPolicy
from agents.train import POLICY, evaluate, initial_action, resolved, train
from tests import toy

ROOT = Path(__file__).resolve().parents[2]
SMALL = {"env": toy.ID, "num_envs": 64, "n_steps": 20, "batch_size": 320, "hidden": [16], "timesteps": 1280}


@pytest.fixture(scope="module", autouse=True)
def _toy():
    toy.install()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(json.dumps(SMALL))  # JSON is YAML
    return path


def run(folder, **changes):
    train(from_mapping({**SMALL, **changes}), folder, show=False)
    return folder


def weights(folder):
    return {name: array.tobytes() for name, array in load_file(folder / POLICY).items()}


def test_same_seed_same_weights(tmp_path):
    first, again, other = (run(tmp_path / name, seed=seed) for name, seed in (("a", 1), ("b", 1), ("c", 2)))
    assert weights(first) == weights(again)
    assert weights(first) != weights(other)


def test_learns_the_toy(tmp_path):
    folder = run(tmp_path / "run", timesteps=40_000, scene={"start": 5.0, "lag": 0.1})
    rows = {row.policy: row for row in evaluate(folder, show=False).rows}
    assert rows["ppo"].score.low > rows["do-nothing"].score.high
    steps, scores = curve.read(folder, toy.LIMIT)
    assert steps[-1] >= 40_000 and scores[-3:].mean() > scores[:3].mean()


def test_mean_starts_at_the_initial_action(tmp_path):
    folder = run(tmp_path / "run", initial_action=[0.5], learning_rate=1e-9)
    actions = TrainedPolicy(folder / POLICY)(np.linspace(-1, 1, 50, dtype=np.float32)[:, None])
    np.testing.assert_allclose(actions, 0.5, atol=0.02)  # the last layer's weights are small, not zero


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"initial_action": [0.1, 0.2]}, "has 2 entries; toy has 1 actions"),
        ({"initial_action": "proportional"}, "no constant policy here; choose one of do-nothing"),
        ({"scene": "plan"}, "no scene 'plan'"),
        ({"env": "vr_envs:vr_envs/BallOnBra-v0"}, "did you mean BallOnBar"),
    ],
)
def test_what_does_not_fit_the_environment_leaves_no_folder(tmp_path, changes, message):
    with pytest.raises(ValueError, match=message):
        run(tmp_path / "run", **changes)
    assert not (tmp_path / "run").exists()


def test_existing_folder_is_refused(tmp_path):
    with pytest.raises(ValueError, match="exists already"):
        run(tmp_path)


def test_time_limit_stops_and_still_saves(tmp_path):
    _, learned = train(from_mapping({**SMALL, "timesteps": 10**9, "time_limit_s": 1.0}), tmp_path / "run", show=False)
    assert learned.timesteps < 10**9 and (tmp_path / "run" / POLICY).exists()


def test_clock_runs_from_one_to_zero():
    assert Clock(None).remaining() == 1.0
    assert 0.9 < Clock(100.0).remaining() <= 1.0
    assert Clock(1e-9).remaining() == 0.0


def test_command_line_trains_and_evaluates(tmp_path, file, capsys):
    out = tmp_path / "run"
    assert command.main(["train", str(file), "--out", str(out), "--no-evaluate", "--quiet", "--set", "gamma=0.9"]) == 0
    assert {p.name for p in out.iterdir()} == {POLICY, "config.yaml", "progress.csv", "learning_curve.png"}
    assert "gamma: 0.9" in (out / "config.yaml").read_text()
    results = tmp_path / "results.json"
    assert command.main(["evaluate", str(out), "--scenarios", "20", "--json", str(results), "--quiet"]) == 0
    assert "| ppo" in capsys.readouterr().out
    assert json.loads(results.read_text())["policies"].keys() >= {"ppo", "proportional", "do-nothing"}
    assert command.main(["evaluate", str(out), "--engine", "rigid_body", "--quiet"]) == 2
    assert "no engine 'rigid_body'; choose one of exact" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train", "absent.yaml"], "No such file"),
        (["train", "{file}", "--set", "gama=0.9"], "did you mean 'gamma'"),
        (["train", "{file}", "--set", "gamma"], "give KEY=VALUE"),
        (["train", "{file}", "--scene", '{{"bund": 1}}'], "did you mean 'bound'"),
        (["evaluate", "absent"], "cannot be read"),
    ],
)
def test_command_line_errors_are_one_line(file, capsys, arguments, message):
    assert command.main([a.format(file=file) for a in arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


@pytest.mark.parametrize("arguments", [["--help"], ["train", "--help"], ["evaluate", "--help"]])
def test_help(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        command.main(arguments)
    assert stopped.value.code == 0 and "usage" in capsys.readouterr().out


def test_configs_fit_their_environments():
    files = sorted((ROOT / "configs").rglob("*.yaml"))
    assert len(files) >= 3
    for path in files:
        config, task, scene = resolved(load(path))
        action = initial_action(config, task, scene)
        assert action is None or len(action) == len(task.action_channels(scene))


def test_whole_run_on_a_registered_id(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("agents.episode.SLOW_MOTION", 1)
    out = tmp_path / "run"
    small = ["--timesteps", "512", *(f"--set={k}" for k in ("num_envs=8", "n_steps=32", "batch_size=128"))]
    arguments = [
        "train",
        str(ROOT / "configs/ball_on_bar/ppo.yaml"),
        "--out",
        str(out),
        "--quiet",
        "--scenarios",
        "4",
        *small,
    ]
    assert command.main(arguments) == 0
    made = {p.name for p in out.iterdir()}
    assert made >= {POLICY, "config.yaml", "progress.csv", "learning_curve.png", "results.json", "results.md"}
    assert (out / "episode.mp4").stat().st_size > 1000
    assert "| ppo" in (out / "results.md").read_text() and str(out) in capsys.readouterr().out


def test_interrupted_training_keeps_what_was_learnt(tmp_path, file, monkeypatch, capsys):
    def interrupt(self):
        raise KeyboardInterrupt

    monkeypatch.setattr("agents.learn._Watch._on_rollout_end", interrupt)
    out = tmp_path / "run"
    assert command.main(["train", str(file), "--out", str(out), "--quiet"]) == 130
    assert TrainedPolicy(out / POLICY).facts["timesteps"] == SMALL["num_envs"] * SMALL["n_steps"]
    assert not (out / "results.json").exists()
