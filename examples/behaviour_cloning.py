"""Behaviour cloning on a system as a Gymnasium environment (extra: games): a driver is watched, then copied."""

import gymnasium
import numpy as np
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

env = gymnasium.make("ichain_drake.environments:ichain/CarGame-v0", path="eight", lookahead=2).unwrapped
SEEN = [
    env.observation_names.index(n) for n in ("wanted.x+2", "wanted.y+2", "car.heading", "car.speed", "car.yaw_rate")
]


def features(rows: np.ndarray) -> np.ndarray:
    """Where to be in two ticks as the driver sees it, ahead and to the side, and how the car moves."""
    x, y, heading, speed, turning = rows[:, SEEN].T
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([cos * x + sin * y, cos * y - sin * x, speed, turning], axis=1)


observations, commands = env.imitation([env.scenario.record_drive(600)])
copy = make_pipeline(StandardScaler(), PolynomialFeatures(3), Ridge(1.0)).fit(features(observations), commands)
for name, policy in {"copy": lambda row: copy.predict(features(row[None]))[0], "rest": lambda _: commands[0]}.items():
    (row, info), over, total = env.reset(seed=100), False, 0.0
    while not over:
        row, reward, ended, late, info = env.step(policy(row))
        over, total = ended or late, total + reward
    print(f"{name}: return {total:.1f} after {info['time']:.1f} s, path done: {info['success']}")
