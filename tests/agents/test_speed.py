import json

import pytest

from agents.__main__ import main
from agents.speed import REPEATS, ROWS, SAMPLES


def test_the_time_of_a_training_is_split(toy, capsys):
    assert main(["speed", toy, "--timesteps", "1"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [t["rows"] for t in found] == [ROWS, ROWS, SAMPLES // 4]
    assert [t["vec_env"] for t in found] == ["DummyVecEnv of scalar environments", *["native batch"] * 2]
    assert all(t["env_id"] == toy and t["steps"] == SAMPLES for t in found)
    for part in ("environments", "policy", "update"):
        assert all(len(t[part]) == REPEATS and min(t[part]) > 0.0 for t in found)


def test_an_unknown_id_is_refused(capsys):
    assert main(["speed", "Nothing"]) == 2
    assert "no environment 'Nothing'" in capsys.readouterr().err


@pytest.mark.parametrize("given", ["0", "x"])
def test_a_number_of_steps_is_needed(given):
    with pytest.raises(SystemExit):
        main(["speed", "TerrainRide", "--timesteps", given])
