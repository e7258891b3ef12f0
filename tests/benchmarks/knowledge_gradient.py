"""Knowledge gradient in closed form against BoTorch's one-shot form, in the same process.

    python -m tests.benchmarks.knowledge_gradient \\
        > tests/benchmarks/results/knowledge_gradient/knowledge_gradient.txt

Both are given the same fitted surrogates of a made-up axis and twin with two gains. What each
proposes is valued by the closed form, so the share of the better value that each reaches can be
compared. The one-shot form has 64 outcomes, 4 descents from 64 starts and 100 steps.
"""

from __future__ import annotations

import time
import warnings

import numpy as np
import torch
from botorch.acquisition.knowledge_gradient import qMultiFidelityKnowledgeGradient
from botorch.acquisition.objective import ScalarizedPosteriorTransform
from botorch.optim.optimize import optimize_acqf
from botorch.sampling.normal import SobolQMCNormalSampler
from botorch.utils.sampling import manual_seed
from numpy.typing import NDArray
from torch import Tensor

from gmfbo.acquisition.knowledge_gradient import FIXED_COST, SOURCE_COST, KnowledgeGradient
from gmfbo.acquisition.maximise import Search, maximise, recommend
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.surrogate.observations import IS1, IS2, Observations, with_source
from gmfbo.surrogate.truncated import TruncatedModel

RUNS = ((2, 10), (6, 20), (10, 40), (20, 80))  # of axis and twin
SEEDS = range(3)
FANTASIES, RESTARTS, RAW, STEPS = 64, 4, 64, 100


def cost_of(points: NDArray[np.float64], source: str) -> NDArray[np.float64]:
    """A bowl with ripples; the twin's is tilted by a wave of its own."""
    x, y = points.T
    bowl = 3.0 * (x - 0.3) ** 2 + 2.0 * (y - 0.6) ** 2 + 0.2 * np.sin(9.0 * x) * np.cos(7.0 * y)
    found: NDArray[np.float64] = bowl + (source == "IS2") * 0.3 * np.sin(5.0 * x + 3.0 * y)
    return found


def observed(axis: int, twin: int, seed: int) -> Observations:
    """Runs at random gains."""
    points = np.random.default_rng(seed).random((axis + twin, 2))
    values = np.r_[cost_of(points[:axis], "IS1"), cost_of(points[axis:], "IS2")]
    return Observations(points, ("IS1",) * axis + ("IS2",) * twin, values)


def project(inputs: Tensor) -> Tensor:
    """The same gains on the axis."""
    return torch.cat([inputs[..., :-1], torch.full_like(inputs[..., -1:], IS1)], dim=-1)


def one_shot(model: TruncatedModel, search: Search, seed: int) -> Tensor:
    """Input (3,) that BoTorch's descent ends at, the better source by its own value."""
    _, least = recommend(model, search)
    found = []
    with exact_algebra(), manual_seed(seed), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of descents that stall
        acquisition = qMultiFidelityKnowledgeGradient(
            model,
            num_fantasies=FANTASIES,
            sampler=SobolQMCNormalSampler(torch.Size([FANTASIES]), seed=seed),
            posterior_transform=ScalarizedPosteriorTransform(torch.tensor([-1.0], dtype=DTYPE)),
            current_value=torch.tensor([-least], dtype=DTYPE),
            project=project,
        )
        for column in (IS1, IS2):
            inputs, value = optimize_acqf(
                acquisition,
                torch.tensor([[0.0] * 3, [1.0] * 3], dtype=DTYPE),
                q=1,
                num_restarts=RESTARTS,
                raw_samples=RAW,
                fixed_features={2: column},
                options={"batch_limit": RESTARTS, "maxiter": STEPS},
            )
            assert value is not None
            found.append((float(value) / (FIXED_COST + SOURCE_COST * column), inputs[0]))
    return max(found, key=lambda pair: pair[0])[1]


def main() -> None:
    print("$ python -m tests.benchmarks.knowledge_gradient")
    print(f"one process, torch {torch.__version__}; CPU time of a proposal, fit not counted\n")
    print(f"{'runs':>8} {'seed':>5} {'one-shot [s]':>13} {'closed [s]':>11} {'value reached':>14}")
    search, times, shares = Search(2), [], []
    for axis, twin in RUNS:
        for seed in SEEDS:
            data = observed(axis, twin, seed)
            model = TruncatedModel.fit(data)
            start = time.process_time()
            proposed = one_shot(model, search, seed)
            middle = time.process_time()
            closed = KnowledgeGradient(model, search)
            best = maximise(closed, search, ("IS1", "IS2"), data)
            end = time.process_time()
            both = torch.stack([proposed, with_source(best.point, best.source)[0]])
            with torch.no_grad():
                values = closed(both[:, None, :]).exp()
            share = float(values[0] / values[1])
            times.append((middle - start, end - middle))
            shares.append(share)
            print(
                f"{axis:4d}+{twin:<3d} {seed:5d} {times[-1][0]:13.2f} {times[-1][1]:11.2f} "
                f"{share:14.2f}",
                flush=True,
            )
    one, other = np.median(times, axis=0)
    print(f"\nmedian time {one:.2f} s and {other:.2f} s: {one / other:.1f} times")
    print(
        f"value of the one-shot proposal over the closed one's: median {np.median(shares):.2f}, "
        f"least {min(shares):.2f}"
    )


if __name__ == "__main__":
    main()
