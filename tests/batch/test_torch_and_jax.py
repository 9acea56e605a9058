"""Impacts as functions that torch and jax differentiate."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik

from .test_derivatives import CASES, LAWS, SCENES, states

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
# Of balls that barely meet, differences have no digits.
NAMES = [name for name in (*CASES, *LAWS) if name != "balls of two sizes"][:20]
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


def functions(name):
    """A scene with two states about one, and its parameters as arrays."""
    scene, q, v = SCENES[name]()
    Q, V = states(scene, q, v, 2)
    more = {}
    if scene.impulses:
        own = zip(scene.entry_names("impulses"), scene.impulses, strict=True)
        more["impulses"] = {n: np.tile(e.values, (2, 1)) for n, e in own}
    plain = all(isinstance(c, ik.Contact) and not callable(c.restitution) for c in scene.contacts)
    if scene.contacts and plain and min(c.restitution for c in scene.contacts) > 0.0:
        more["restitution"] = np.array([[c.restitution for c in scene.contacts]] * 2)
        more["friction"] = np.array([[c.friction for c in scene.contacts]] * 2)
        contacts = zip(scene.entry_names("contacts"), scene.contacts, strict=True)
        more["points"] = {n: np.tile(c.at, (2, 1)) for n, c in contacts}
    return scene, Q, V, more


def flat(more):
    """The arrays of the parameters, and a function that puts others in their places."""
    arrays = [
        x for own in more.values() for x in (own.values() if isinstance(own, dict) else [own])
    ]

    def put(values):
        rest = iter(values)
        return {
            kind: {n: next(rest) for n in own} if isinstance(own, dict) else next(rest)
            for kind, own in more.items()
        }

    return arrays, put


@pytest.mark.parametrize("name", NAMES)
def test_torch_gradcheck(name):
    torch = pytest.importorskip("torch")
    from impulsekit.torch import solve

    scene, Q, V, more = functions(name)
    arrays, put = flat(more)
    tensors = [torch.tensor(x, requires_grad=True, dtype=torch.float64) for x in (Q, V, *arrays)]

    def after(q, v, *rest):
        return solve(scene, q, v, **put(rest))

    assert solve(scene, *tensors[:2], return_mask=True, **put(tensors[2:]))[1].all()
    # Nearest points of meshes are found to fewer digits than differences over 1e-6 need.
    eps, bar = (1e-5, 2e-7) if name.endswith("a face") else (1e-6, 1e-8)
    assert torch.autograd.gradcheck(after, tensors, eps=eps, atol=bar, rtol=bar)


@pytest.mark.parametrize("name", NAMES[::5])
def test_jax_check_grads(name):
    jax = pytest.importorskip("jax")
    from jax.test_util import check_grads

    from impulsekit.jax import solve

    with jax.enable_x64(True):
        scene, Q, V, more = functions(name)
        arrays, put = flat(more)

        def after(q, v, *rest):
            return solve(scene, q, v, **put(rest))

        check_grads(after, (Q, V, *arrays), order=1, modes=["rev"], atol=1e-5, rtol=1e-5)
        whole, one = jax.jit(after)(Q, V, *arrays), jax.vmap(after)(Q, V, *arrays)
        np.testing.assert_array_equal(whole, one)
        after = ik.solve_batch(scene, Q, V).v_after
        np.testing.assert_allclose(whole, after, rtol=1e-12, atol=1e-12)


def test_kinds_shapes_and_masks():
    torch = pytest.importorskip("torch")
    from impulsekit.torch import solve

    scene = ik.Scene(BALL, contacts=[ik.Contact("ball", friction=0.5)])
    V = torch.tensor([[0, 0, -2.0, 0, 0, 0], [0, 0, torch.nan, 0, 0, 0]], requires_grad=True)
    e = torch.tensor(0.5, requires_grad=True)
    q = torch.tensor(BALL.neutral(), dtype=torch.float32)
    after, mask = solve(scene, q, V, restitution=e, return_mask=True)
    assert after.dtype == torch.float32 and mask.tolist() == [True, False]
    after[0, 2].backward()
    assert e.grad == 2.0 and V.grad[:, 2].tolist() == [-0.5, 0.0]
    assert solve(scene, q, V[0]).shape == (6,)
    with pytest.raises(ik.errors.InputError, match="no parameter"):
        solve(scene, q, V, mu=0.1)


def test_a_fit_of_restitution_and_friction_converges():
    torch = pytest.importorskip("torch")
    from impulsekit.torch import solve

    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    scene = ik.Scene(box, contacts=[ik.Contact("box", at=[0.1, 0.05, -0.05])])
    rng = np.random.default_rng(0)
    V = rng.normal(size=(200, 6)) - 3.0 * np.eye(6)[2]
    true = ik.solve_batch(scene, box.neutral(), V, restitution=0.6, friction=0.15).v_after
    q, V, true = (torch.from_numpy(np.array(x)) for x in (box.neutral(), V, true))
    x = torch.tensor([-1.0, -1.0], dtype=torch.float64, requires_grad=True)
    fit = torch.optim.LBFGS([x], max_iter=60, line_search_fn="strong_wolfe", tolerance_grad=1e-12)

    def loss():
        fit.zero_grad()
        after = solve(scene, q, V, restitution=torch.sigmoid(x[0]), friction=torch.exp(x[1]))
        off = (after - true).square().mean()
        off.backward()
        return off

    fit.step(loss)
    found = torch.sigmoid(x[0]).item(), torch.exp(x[1]).item()
    np.testing.assert_allclose(found, [0.6, 0.15], atol=1e-5)


@pytest.mark.parametrize("framework", ["torch", "jax"])
@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"v": np.zeros((2, 7))}, "ShapeError", r"v: expected shape \(B, 6\), got \(1, 7\)"),
        ({"q": np.zeros(6)}, "ShapeError", "q: expected shape"),
        ({"restitution": np.zeros((2, 3))}, "ShapeError", "restitution: expected shape"),
        ({"points": {"flor": np.zeros(3)}}, "UnknownNameError", 'did you mean "floor"'),
        ({"masses": {"bal": 1.0}}, "UnknownNameError", 'did you mean "ball"'),
    ],
)
def test_shapes_and_names_are_checked_before_the_framework_calls_back(
    framework, more, error, words
):
    library = pytest.importorskip(framework)
    from importlib import import_module

    made = library.tensor if framework == "torch" else library.numpy.asarray
    floor = ik.Contact("ball", name="floor")
    given = {"q": BALL.neutral(), "v": np.zeros((2, 6)), **more}
    given = {
        k: {n: made(x) for n, x in a.items()} if isinstance(a, dict) else made(a)
        for k, a in given.items()
    }
    solve = import_module(f"impulsekit.{framework}").solve
    with pytest.raises(getattr(ik.errors, error), match=words):
        solve(ik.Scene(BALL, contacts=[floor]), **given)
