import json

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from safetensors.numpy import save_file
from stable_baselines3.common.policies import ActorCriticPolicy

from agents.policy import TrainedPolicy, policy_kwargs, save_policy

OBSERVATION = Box(np.full(5, -2, np.float32), np.full(5, 3, np.float32), dtype=np.float32)
ACTION = Box(-1, 1, (3,), np.float32)
FACTS = {"hidden": [16, 8], "activation": "elu", "env": "x", "scene": {"base": "plain"}}


@pytest.fixture
def saved(tmp_path):
    torch.manual_seed(1)
    network = ActorCriticPolicy(OBSERVATION, ACTION, lambda _: 0.0, **policy_kwargs((16, 8), "elu"))
    with torch.no_grad():
        network.action_net.weight.mul_(300.0)  # so that some means lie outside the box
    path = tmp_path / "policy.safetensors"
    save_policy(network, path, FACTS)
    return network, path


def test_loaded_policy_acts_to_the_same_bytes(saved):
    network, path = saved
    policy = TrainedPolicy(path, OBSERVATION, ACTION)
    policy.reset(64)
    observations = np.random.default_rng(0).uniform(-2, 3, (64, 5)).astype(np.float32)
    expected, _ = network.predict(observations, deterministic=True)
    actions = policy(observations)
    assert actions.dtype == np.float32 and actions.tobytes() == expected.tobytes()
    assert (np.abs(actions) == 1).any() and (np.abs(actions) < 1).any()


def test_facts_and_spaces_survive(saved):
    facts = TrainedPolicy(saved[1]).facts
    assert {k: facts[k] for k in FACTS} == FACTS


def test_other_spaces_are_refused(saved):
    with pytest.raises(ValueError, match="observation space"):
        TrainedPolicy(saved[1], Box(-1, 1, (5,), np.float32), ACTION)
    with pytest.raises(ValueError, match="action space"):
        TrainedPolicy(saved[1], OBSERVATION, Box(-1, 1, (2,), np.float32))


def test_what_is_no_policy_is_refused(tmp_path):
    with pytest.raises(ValueError, match="cannot be read"):
        TrainedPolicy(tmp_path / "absent.safetensors")
    (tmp_path / "text").write_text("not a policy")
    with pytest.raises(ValueError, match="cannot be read"):
        TrainedPolicy(tmp_path / "text")
    save_file({"a": np.zeros(2)}, tmp_path / "foreign.safetensors")
    with pytest.raises(ValueError, match="format None"):
        TrainedPolicy(tmp_path / "foreign.safetensors")


@pytest.mark.parametrize("damage", ["no facts", "facts cut off", "no spaces", "weights of another network"])
def test_a_damaged_policy_is_refused(saved, tmp_path, damage):
    facts = {**FACTS, "spaces": TrainedPolicy(saved[1]).facts["spaces"]}
    if damage == "weights of another network":
        facts["hidden"] = [16]
    if damage == "no spaces":
        del facts["spaces"]
    header = {"format": "vr_envs policy 1", "facts": json.dumps(facts)}
    if damage == "no facts":
        del header["facts"]
    if damage == "facts cut off":
        header["facts"] = header["facts"][:20]
    weights = {name: tensor.numpy() for name, tensor in saved[0].state_dict().items()}
    save_file(weights, tmp_path / "damaged.safetensors", header)
    with pytest.raises(ValueError, match="damaged"):
        TrainedPolicy(tmp_path / "damaged.safetensors")
