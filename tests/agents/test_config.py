import pytest

from agents.config import Config, dump, from_mapping, load, parse

ENV = "vr_envs:vr_envs/BallOnBar-v0"


def test_defaults_and_round_trip():
    config = from_mapping({"env": ENV, "scene": {"base": "bell", "scatter": None}, "initial_action": [0.5, -1]})
    assert config == Config(ENV, {"base": "bell", "scatter": None}, initial_action=(0.5, -1.0))
    assert from_mapping(parse(dump(config), "dump")) == config


def test_file_and_overrides(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(f"env: {ENV}\nlearning_rate: 3e-4\ntimesteps: 2_000_000\ntarget_kl: null\nseed: 4\n")
    config = load(path, {"seed": 7})
    assert (config.learning_rate, config.timesteps, config.target_kl, config.seed) == (3e-4, 2_000_000, None, 7)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"gama": 0.9}, r"no key 'gama'; did you mean 'gamma'\? Allowed: env, scene"),
        ({"gamma": "high"}, "gamma = 'high' is not a number"),
        ({"gamma": 1.5}, r"gamma = 1.5 is not allowed.*\[0, 0.99999\]"),
        ({"gamma": float("nan")}, "gamma = nan is not allowed"),
        ({"num_envs": 2.5}, "num_envs = 2.5 is not a whole number"),
        ({"num_envs": True}, "num_envs = True is not a number"),
        ({"algorithm": "sac"}, "choose one of ppo"),
        ({"activation": "torch.nn.Tanh"}, "choose one of tanh, relu, elu"),
        ({"hidden": [64, 0]}, "list of ints"),
        ({"hidden": 64}, "list of ints"),
        ({"initial_action": [2.0]}, "list of floats"),
        ({"initial_action": {}}, "list of floats"),
        ({"scene": 3}, "scene = 3 is not allowed"),
        ({"env": ""}, "env = '' is not allowed"),
        ({"timesteps": None}, "timesteps = None is not a number"),
        ({"num_envs": 512, "n_steps": 64, "batch_size": 5000}, "does not divide"),
    ],
)
def test_bad_values_are_named(values, message):
    with pytest.raises(ValueError, match=message):
        from_mapping({"env": ENV, **values})


def test_env_is_required():
    with pytest.raises(ValueError, match="'env' is missing"):
        from_mapping({})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "give keys and values, not list"),
        ("env: [", "a.yaml: while parsing"),
        ("env: x\nseed: 1\nseed: 2\n", r"'seed' is given twice \(line 3\)"),
        ("env: !!python/object/apply:os.getcwd []", "could not determine a constructor"),
    ],
)
def test_bad_files_are_one_line_errors(tmp_path, text, message):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_missing_file(tmp_path):
    with pytest.raises(ValueError, match="No such file"):
        load(tmp_path / "absent.yaml")
