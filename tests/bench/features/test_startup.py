"""What a start loads, and what the report says of it."""

import json

import pytest

from vr_envs.__main__ import main
from vr_envs.bench.features import sentences, startup
from vr_envs.bench.features.startup import STAGES, Cold, Stage, Start, Warm
from vr_envs.bench.timing import Spread


def test_a_start_loads_what_draws_only_for_a_picture():
    """Modules counted in a process of its own."""
    found = startup.start("vr_envs/TerrainRide-v0", look=True)
    assert tuple(found.stages) == STAGES
    assert found.stages["vr_envs"].modules == 1 and found.stages["vr_envs"].heavy == []
    for name in STAGES[:-1]:
        assert not {"pygame", "matplotlib", "vr_envs.render", "torch", "pymunk"} & set(found.stages[name].heavy)
    assert "vr_envs.render" in found.stages["picture"].heavy
    assert all(stage.cpu >= 0.0 and stage.wall > 0.0 for stage in found.stages.values())


def test_a_start_that_fails_says_how():
    with pytest.raises(RuntimeError, match="(?s)vr_envs/Kite-v0 does not start in a new process: .*Kite"):
        startup.start("vr_envs/Kite-v0")


def one(value):
    return Spread(value, value, value)


def test_sentences_say_so_where_a_goal_is_missed():
    good, bad = (
        Warm("a", 0, one(0.1), one(0.001), one(0.2), one(0.4)),
        Warm("b", 64, one(0.1), one(0.001), one(0.2), one(1.2)),
    )
    assert "0.40 s of CPU time at most (a), less than 1 s" in sentences.warm([good])
    assert "1.20 s of CPU time at most (b), not less than 1 s" in sentences.warm([good, bad])
    assert "12.0 s (A-v0) of CPU time, all below 15 s, with a word after 2 s" in sentences.cold(
        [Cold("x/A-v0", 12.0, 14.0, True)]
    )
    slow = sentences.cold([Cold("x/A-v0", 12.0, 14.0, False), Cold("x/B-v0", 16.0, 20.0, True)])
    assert "of which x/B-v0 not below 15 s, without a word from x/A-v0" in slow


def test_sentences_name_what_draws_too_early():
    def start(early):
        return Start({"vr_envs": Stage("vr_envs", 0.1, 0.1, 1, []), "make": Stage("make", 0.1, 0.1, 5, early)}, "")

    assert "nothing that draws is loaded before" in sentences.imports({"a": start(["numba"])})
    assert "but pygame is loaded" in sentences.imports({"a": start(["numba"]), "b": start(["pygame"])})


def test_the_command_writes_a_report(toy, capsys, tmp_path, monkeypatch):
    stages = {name: Stage(name, 0.2, 0.1, 1, []) for name in STAGES}
    monkeypatch.setattr(startup, "start", lambda *_, **__: Start(stages, ""))
    assert main(["bench", "features", "--quick", "--id", toy, "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    stored = json.loads((tmp_path / "features.json").read_text())
    assert {"options_on", "options_off", "finished_rows", "metrics", "warm_starts"} <= set(stored["numbers"])
    (off,) = [cost for cost in stored["numbers"]["options_off"]["toy"] if cost["name"] == "no option"]
    assert off["instructions"]["optimised"] == off["other_instructions"]["optimised"]
    assert "leaves nothing that calculates in the compiled code of 2 of 2 scenes" in out
    assert (tmp_path / "features-options.png").read_bytes()[:4] == b"\x89PNG"
    for title in ("Options that are on: toy", "Options that are off", "Finished rows", "Metrics at the end"):
        assert f"### {title}" in (tmp_path / "features.md").read_text()


def test_an_unknown_id_is_refused(capsys, tmp_path):
    assert main(["bench", "features", "--id", "Kite", "--out", str(tmp_path)]) == 2
    assert "no environment 'Kite'" in capsys.readouterr().err
