"""Random contact problems of nasty kinds through every law of the core.

``python -m tests.core.fuzz_laws 1000000`` goes through as many: none may crash or hang, and what is
called SOLVED has to obey the law, judged here from its definition.
"""

import sys

import numpy as np

from impulsekit import Status
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
from impulsekit.scene.law import Law

LAWS = (
    Law(),
    Law(restitution="poisson"),
    Law(order="sequential"),
    Law(restitution="stronge", slip="path", order="sequential"),
    Law(restitution="lzb"),
)
# Where it is judged: what an answer may lack of the law, relative.
BAR = 1e-8


def problem_of(rng: np.random.Generator) -> ContactProblem:
    """Random rows and masses; at times redundant, far apart in size, or at rest."""
    n, nv = int(rng.integers(1, 5)), int(rng.integers(1, 14))
    rows = rng.normal(size=(3 * n, nv))
    if rng.uniform() < 0.2 and n > 1:
        rows[3:6] = rows[:3] * (1.0 + rng.choice([0.0, 1e-4, 1e-9]) * rng.normal())
    if rng.uniform() < 0.2:
        rows *= 10.0 ** rng.uniform(-3, 3, size=(1, nv))
    if rng.uniform() < 0.2:
        rows[1::3] = 0.0
    W, v = rows @ rows.T, rng.normal(size=nv) * (rng.uniform() > 0.1)
    before = rows @ v
    free = before + (rows @ rng.normal(size=nv) if rng.uniform() < 0.3 else 0.0)
    e, mu = rng.choice([0.0, 0.5, 1.0], n), rng.choice([0.0, 0.3, 0.9, 4.0], n)
    return ContactProblem(W, before, free, e, mu, np.zeros(n), stiffness=rng.uniform(0.5, 2, n))


def lack_of_newton(problem: ContactProblem, impulse: np.ndarray) -> float:
    """What an answer lacks of Newton's law with slip at the end, relative, by the definition."""
    W, e, mu = problem.delassus, problem.restitution, problem.friction
    xi = problem.velocity_free + W @ impulse
    xi[2::3] += e * np.minimum(problem.velocity_before[2::3], 0.0)
    terms = np.abs(problem.velocity_free) + np.abs(W) @ np.abs(impulse)
    worst = 0.0
    for i in range(len(mu)):
        own, (p, n) = slice(3 * i, 3 * i + 2), (impulse[3 * i : 3 * i + 2], impulse[3 * i + 2])
        rate = W[3 * i + 2, 3 * i + 2]
        size = max(terms[3 * i : 3 * i + 3].max(), 1e-300)
        worst = max(worst, -n * rate / size, -xi[3 * i + 2] / size)
        worst = max(worst, min(n * rate, xi[3 * i + 2]) / size)
        slip, tangential = np.hypot(*xi[own]), np.hypot(*p)
        worst = max(worst, (tangential - mu[i] * n) * rate / size)
        if slip > 1e-9 * size and mu[i] > 0.0:
            worst = max(worst, np.abs(p + mu[i] * n * xi[own] / slip).max() * rate / size)
    return float(worst)


def fuzz(count: int, seed: int = 0) -> tuple[dict[str, int], float]:
    """Statuses of so many problems, and the largest lack of what is SOLVED under Newton's law."""
    rng, found, worst = np.random.default_rng(seed), {}, 0.0
    for k in range(count):
        law, problem = LAWS[k % len(LAWS)], problem_of(rng)
        solution = solve_contacts(problem, law)
        found[solution.status.name] = found.get(solution.status.name, 0) + 1
        if law == Law() and solution.status is Status.SOLVED:
            lack = lack_of_newton(problem, solution.impulse)
            worst = max(worst, lack)
    return found, worst


if __name__ == "__main__":
    print(*fuzz(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000))
