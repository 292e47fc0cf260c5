import dataclasses
import json
import subprocess
import sys
import types

import numpy as np
import pytest

from tests.toy import LIMIT
from vr_envs.__main__ import main
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.scene import resolve
from vr_envs.render.film import pace, pictures

HEAVY = ("numba", "scipy", "matplotlib", "pygame", "torch", "pymunk", "imageio", "cma")


def refused(capsys, *arguments):
    """The one line on stderr with which a command line is refused."""
    try:
        code = main(arguments)
    except SystemExit as end:
        code = end.code
    captured = capsys.readouterr()
    assert code == 2
    assert "Traceback" not in captured.err
    return captured.err.strip().splitlines()[-1]


def test_starting_up_loads_nothing_heavy():
    code = f"import sys, vr_envs.__main__ as m; m.parser(); print([x for x in {HEAVY!r} if x in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_the_module_is_the_command():
    result = subprocess.run(
        [sys.executable, "-m", "vr_envs", "evaluate", "Nothing-v0"], capture_output=True, text=True, check=False
    )
    assert result.returncode == 2
    assert result.stderr.startswith("vr-envs evaluate: error: there is no environment 'Nothing-v0'")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "command",
    [[], ["list"], ["evaluate"], ["render"], ["tune"], ["bench"], ["bench", "speed"], ["experiment"]],
    ids=" ".join,
)
def test_help_has_examples(capsys, command):
    with pytest.raises(SystemExit) as end:
        main([*command, "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert text.startswith(f"usage: {' '.join(['vr-envs', *command])}")
    assert not command or "examples:\n  vr-envs" in text


def test_list_one(toy, capsys):
    assert main(["list", toy, "--scene", '{"base": "biased", "lag": 0.25}']) == 0
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in capsys.readouterr().out.splitlines()]
    assert ["parameter", "plain", "biased", "narrow", "yours", "unit", "allowed", "meaning"] in lines
    assert ["lag", "1", "1", "1", "0.25", "s", "[0.01, 100]", "time constant"] in lines
    assert ["bias.size", "(0.5)", "0.5", "(0.5)", "0.5", "", "[-1, 1]", "constant action added by the world"] in lines
    assert ["0", "push", "[-1, 1]", "1", "share of the full push"] in lines


def test_evaluate_prints_a_table_per_level_and_writes_json(toy, capsys, tmp_path):
    path = tmp_path / "out.json"
    arguments = ["evaluate", toy, "--scene", "biased", "--level", "all", "--scenarios", "10", "--seed", "2"]
    assert main([*arguments, "--policies", "cancel, random", "--json", str(path)]) == 0
    captured = capsys.readouterr()
    told = [line for line in captured.err.splitlines() if not line.startswith("vr_envs: compiling")]  # a busy machine
    assert told == []
    assert captured.out.count("10 held-out scenarios (seed 2)") == 3
    assert "| cancel" in captured.out
    assert "| proportional" not in captured.out
    reports = json.loads(path.read_text())
    assert [r["level"] for r in reports] == ["nominal", "light", "severe"]
    assert list(reports[0]["policies"]) == ["cancel", "random"]


def test_evaluate_with_another_engine(capsys, tmp_path):
    out = tmp_path / "out.json"
    scene = '{"rigid_body": {"step": 5e-4}}'
    arguments = ["evaluate", "BallOnBar", "--scene", scene, "--scenarios", "2", "--policies", "bell-sink"]
    assert main([*arguments, "--json", str(out)]) == 0
    assert "scene bell with rigid_body, level nominal: 2 " in capsys.readouterr().out
    assert json.loads(out.read_text())[0]["scene"]["rigid_body"] == {"step": 5e-4}
    assert main([*arguments, "--engine", "exact"]) == 0
    assert "scene bell, level nominal: 2 " in capsys.readouterr().out


def test_evaluate_refuses_in_one_line(toy, capsys, tmp_path):
    assert "choose one of plain, biased, narrow" in refused(capsys, "evaluate", toy, "--scene", "moon")
    assert "did you mean 'push'?" in refused(capsys, "evaluate", toy, "--scene", '{"pusch": 1}')
    assert "finite and in [0, 10]" in refused(capsys, "evaluate", toy, "--scene", '{"push": 11}')
    assert "not JSON" in refused(capsys, "evaluate", toy, "--scene", "{push: 11}")
    assert "choose among do-nothing" in refused(capsys, "evaluate", toy, "--policies", "best")
    assert "nominal, light, severe" in refused(capsys, "evaluate", toy, "--level", "hard")
    assert "no engine 'rigid_body'; choose one of exact" in refused(capsys, "evaluate", toy, "--engine", "rigid_body")
    assert "at least 2" in refused(capsys, "evaluate", toy, "--scenarios", "1")
    assert "there is no folder" in refused(capsys, "evaluate", toy, "--json", str(tmp_path / "no" / "out.json"))
    assert "is a folder" in refused(capsys, "evaluate", toy, "--json", str(tmp_path))


def test_tune_stores_and_tells(toy, capsys, tmp_path):
    assert main(["tune", toy, "--scene", "biased", "--evaluations", "30", "--scenarios", "4"]) == 0
    out = capsys.readouterr().out
    assert "best-constant: 0." in out
    assert f"written to {tmp_path / 'toy.json'}" in out
    assert set(json.loads((tmp_path / "toy.json").read_text())["biased"]) == {"best-constant", "proportional"}
    assert "nothing to tune" in refused(capsys, "tune", toy, "--policy", "cancel")
    assert "at least 30" in refused(capsys, "tune", toy, "--evaluations", "3")


def test_tune_without_its_package_says_what_to_install(toy, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)
    assert "pip install '.[tune]' in a clone" in refused(capsys, "tune", toy, "--evaluations", "30")


def test_bench_speed_prints_and_writes(toy, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("vr_envs.bench.speed.training.missing", lambda: "No training here.")
    command = ["bench", "speed", "--quick", "--id", toy, "--rows", "1,8", "--repeats", "1", "--out", str(tmp_path)]
    assert main(command) == 0
    out = capsys.readouterr().out
    assert "No training here." in out and "| CartPole-v1 " in out and "1 of 1 goals" not in out.splitlines()[0]
    found = json.loads((tmp_path / "speed.json").read_text())["numbers"]["steps_per_cpu_second"]
    kinds = {(s["case"], s["family"], s["rows"]) for s in found}
    for actions in ("", ", small actions"):
        for form in ("native batch", "SyncVectorEnv"):
            assert {(f"FirstOrder default{actions}", form, rows) for rows in (1, 8)} <= kinds
    assert "no environment 'Toy'" in refused(capsys, "bench", "speed", "--id", "Toy")
    assert "at least 1" in refused(capsys, "bench", "speed", "--rows", "1,0")


class Artist:
    """Stands in for the pictures: a frame is filled with the step count of the state it shows."""

    def __init__(self, *_):
        pass

    def draw(self, state):
        return np.full((4, 4, 3), state["steps"], np.uint8)

    def close(self):
        pass


class SlowArtist(Artist):
    def frames(self, before, after, n):
        assert before["steps"] + 1 == after["steps"]
        for k in range(n):
            yield np.full((4, 4, 3), 100 * k + after["steps"], np.uint8)


@pytest.fixture
def film(monkeypatch):
    written = {}
    fake = types.ModuleType("vr_envs.render")

    def write_animation(path, frames, fps):
        written[str(path)] = ([int(f[0, 0, 0]) for f in frames], fps)

    vars(fake).update(painter=Artist, write_animation=write_animation)
    monkeypatch.setitem(sys.modules, "vr_envs.render", fake)
    return written


def test_render_shows_every_step_to_the_end(toy, film, tmp_path):
    path = str(tmp_path / "a.gif")
    assert main(["render", toy, "--out", path]) == 0
    assert film[path] == (list(range(LIMIT + 1)), 10.0)
    assert main(["render", toy, "--out", path, "--seconds", "0.5", "--policy", "random", "--scenario", "3"]) == 0
    assert film[path][0] == [0, 1, 2, 3, 4, 5]


def test_render_stops_where_the_episode_ends(toy, film, tmp_path):
    path = str(tmp_path / "a.mp4")
    assert main(["render", toy, "--scene", '{"bound": 0.0}', "--out", path]) == 0
    assert film[path][0] == [0, 1]


def test_render_refuses_in_one_line(toy, film, capsys, tmp_path):
    assert ".gif, .mp4, .png" in refused(capsys, "render", toy, "--out", "film.avi")
    assert "choose among" in refused(capsys, "render", toy, "--policy", "best")
    assert "2^64" in refused(capsys, "render", toy, "--scenario", str(2**64))
    assert "above 0" in refused(capsys, "render", toy, "--seconds", "nan")
    assert film == {}


def test_render_between_the_steps_is_slow_motion(toy, film, capsys, tmp_path):
    path = str(tmp_path / "a.gif")
    arguments = ("render", toy, "--out", path, "--seconds", "0.3", "--between", "2")
    assert "no pictures between" in refused(capsys, *arguments)
    sys.modules["vr_envs.render"].painter = SlowArtist
    assert main(arguments) == 0
    assert film[path] == ([0, 1, 101, 2, 102, 3, 103], 30.0)


def test_render_without_its_packages_says_what_to_install(capsys, monkeypatch, tmp_path):
    for module in ("pygame", "imageio", "imageio.v2"):
        monkeypatch.setitem(sys.modules, module, None)
    assert "pip install '.[render]' in a clone" in refused(
        capsys, "render", "BallOnBar", "--out", str(tmp_path / "a.gif")
    )
    assert list(tmp_path.iterdir()) == []


def test_strides_keep_the_first_and_the_last_state():
    states = [np.array([(k,)], [("steps", "i8")])[0] for k in range(6)]
    shown = [int(f[0, 0, 0]) for f in pictures(Artist(), states, 2, 1)]
    assert shown == [0, 2, 4, 5]


@pytest.mark.parametrize(("dt", "stride", "fps"), [(0.01, 3, 1 / 0.03), (1 / 15, 1, 15.0), (1.0, 1, 10.0)])
def test_pictures_are_in_real_time_where_steps_are_short(dt, stride, fps):
    assert pace(dt) == (stride, pytest.approx(fps))


def test_list_has_a_line_per_id(capsys):
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:]] == ids()


@pytest.mark.parametrize("env_id", ids())
def test_list_names_every_parameter_and_channel(capsys, env_id):
    task = task_of(env_id)
    for name in task.scenes:
        assert main(["list", env_id, "--scene", name]) == 0
        text = capsys.readouterr().out
        scene = resolve(task, name)
        fields = [f.name for f in dataclasses.fields(task.params)]
        fields += [f"{option}.{f.name}" for option, cls in task.additions.items() for f in dataclasses.fields(cls)]
        fields += [option for option, cls in task.additions.items() if not dataclasses.fields(cls)]
        channels = [c.name for c in (*task.observation_channels(scene), *task.action_channels(scene))]
        for expected in fields:
            assert f"\n| {expected} " in text
        for expected in channels:
            assert f" | {expected} " in text
