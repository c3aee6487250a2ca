#!/usr/bin/env bash
# gymnasium 1.4.0: how NormalizeReward scales a reward that is paid at the end of an episode.
#
# Guess before the run: the wrapper divides rewards by the spread of the discounted return, which starts at 0 in each
# episode. A success reward of 10 at step 10, and nothing before, gets the same scale by the wrapper of one environment
# and from that of vectors, in both autoreset modes.
# Seen: 3.3 with SAME_STEP, 14.3 in one environment and with NEXT_STEP. There the return is not cleared: the last reward
# runs on in the next episode, the return stays between 9 and 10, and its spread shrinks. If the last step is a time
# limit and not a terminal state, it is never cleared: it grows to 103, and the same reward is scaled to 0.63.
# Why it matters: the scale of the reward of one task differs by a factor of 20 with the autoreset mode and with how
# episodes end, so settings of a learner do not carry over. The sparser the reward, the greater the difference.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile gymnasium==1.4.0
cat > "$work/rewards.py" <<'PY'
import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import NormalizeReward
from gymnasium.wrappers.vector import NormalizeReward as VectorNormalizeReward

STEPS = 10
GAMMA = 0.99


class PaidAtTheEnd(gymnasium.Env):
    """Ten steps; the last one pays 10."""

    observation_space = gymnasium.spaces.Box(-1, 1, (1,))
    action_space = gymnasium.spaces.Box(-1, 1, (1,))

    def __init__(self, truncate):
        self.truncate = truncate

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.steps = 0
        return np.zeros(1, np.float32), {}

    def step(self, action):
        self.steps += 1
        last = self.steps == STEPS
        return np.zeros(1, np.float32), 10.0 * last, last and not self.truncate, last and self.truncate, {}


def alone(truncate):
    """Scaled reward of the last episode, and the accumulator one step after its reset."""
    env = NormalizeReward(PaidAtTheEnd(truncate), gamma=GAMMA)
    for _ in range(200):
        env.reset()
        first = None
        for _ in range(STEPS):
            reward = env.step(np.zeros(1))[1]
            first = env.discounted_reward if first is None else first
    return float(reward), float(np.ravel(first)[0])


def in_a_vector(truncate, mode):
    """The same of two environments."""
    env = VectorNormalizeReward(
        SyncVectorEnv([lambda: PaidAtTheEnd(truncate)] * 2, autoreset_mode=mode), gamma=GAMMA
    )
    env.reset()
    rewards, sums = [], []
    for _ in range(200 * (STEPS + (mode is AutoresetMode.NEXT_STEP))):
        _, reward, _, _, _ = env.step(np.zeros((2, 1)))
        rewards.append(reward[0])
        sums.append(env.accumulated_reward[0])
    paid = np.flatnonzero(rewards)[-2]
    return float(rewards[paid]), float(sums[paid + 1 + (mode is AutoresetMode.NEXT_STEP)])


print("gymnasium", gymnasium.__version__, "- a reward of 10 at the last of", STEPS, "steps, 200 episodes")
for truncate in (False, True):
    for name, (scaled, left) in {
        "one environment": alone(truncate),
        "vector, NEXT_STEP": in_a_vector(truncate, AutoresetMode.NEXT_STEP),
        "vector, SAME_STEP": in_a_vector(truncate, AutoresetMode.SAME_STEP),
    }.items():
        end = "truncated" if truncate else "terminated"
        print(f"{end:10s} {name:17s} scaled to {scaled:6.2f}, return after the next episode's first step {left:.2f}")
        if "SAME_STEP" in name:
            wanted = (3.33, 0.0)
        else:
            wanted = (0.63, 103.54) if truncate else (14.3, 9.9)
        assert abs(scaled - wanted[0]) < 0.1 and abs(left - wanted[1]) < 0.1, (name, scaled, left)
PY
"$work/venv/bin/python" "$work/rewards.py"
