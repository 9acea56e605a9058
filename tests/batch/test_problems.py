"""Contact problems given by their matrices: the same as one by one, in the arrays given."""

import numpy as np
import pytest

import impulsekit as ik

from ..laws.rows import solved_rows


def problems(count, contacts, seed=0):
    """Rows of contacts on unit masses, with more freedom than rows."""
    random = np.random.default_rng(seed)
    J = random.normal(size=(count, 3 * contacts, 3 * contacts + 2))
    v = random.normal(size=(count, 3 * contacts + 2))
    return J, v, J @ J.transpose(0, 2, 1), np.einsum("nij,nj->ni", J, v)


@pytest.mark.parametrize("law", [ik.Law(), ik.Law("poisson"), ik.Law(order="sequential")])
@pytest.mark.parametrize("contacts", [1, 2, 4])
def test_they_are_as_in_a_scene(law, contacts):
    J, v, W, free = problems(40, contacts)
    found = ik.solve_contact_problems(W, free, restitution=0.4, friction=0.3, law=law)
    assert found.valid.dtype == bool
    for i in np.flatnonzero(found.valid):
        impact = solved_rows(J[i], v[i], e=0.4, mu=0.3, law=law)
        assert found.status[i] == impact.status
        assert np.allclose(found.velocity_after[i], J[i] @ impact.v_after, atol=1e-9)
    assert found.valid.mean() > 0.8


def test_many_on_threads_have_the_bits_of_one_by_one():
    _, _, W, free = problems(300, 4)
    e, mu = np.linspace(0, 1, 300 * 4).reshape(300, 4), np.full(4, 0.6)
    many = ik.solve_contact_problems(W, free, restitution=e, friction=mu, threads=3)
    for i in range(0, 300, 17):
        one = ik.solve_contact_problems(
            W[i : i + 1], free[i : i + 1], restitution=e[i], friction=mu, threads=1
        )
        assert np.array_equal(one.impulses[0], many.impulses[i])
    assert np.abs(many.residual[many.valid]).max() < 1e-9
    left = free + np.einsum("nij,nj->ni", W, many.impulses) - many.velocity_after
    assert np.abs(left[many.valid]).max() < 1e-9


def test_tensors_in_give_tensors_out():
    torch = pytest.importorskip("torch")
    _, _, W, free = problems(5, 2)
    plain = ik.solve_contact_problems(W, free, friction=0.5)
    given = torch.tensor(W, requires_grad=True), torch.tensor(free, dtype=torch.float32)
    found = ik.solve_contact_problems(*given, friction=torch.tensor(0.5))
    assert found.impulses.dtype == torch.float32
    assert found.valid.dtype == torch.bool
    assert np.allclose(found.impulses.numpy(), plain.impulses, atol=1e-4)


def test_no_problems_are_no_answers():
    found = ik.solve_contact_problems(np.zeros((0, 3, 3)), np.zeros((0, 3)))
    assert found.impulses.shape == (0, 3)


W, FREE = np.eye(3)[None], np.zeros((1, 3))


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ((np.eye(4), np.zeros((1, 4))), ik.errors.ShapeError, "3n"),
        ((np.eye(6), FREE), ik.errors.ShapeError, "W"),
        ((W * np.nan, FREE), ik.errors.NotFiniteError, "W"),
        ((W, FREE + np.inf), ik.errors.NotFiniteError, "free"),
        ((W + np.triu(np.ones((3, 3)), 1), FREE), ik.errors.RangeError, "symmetric"),
        (("W", FREE), ik.errors.InputError, "W must be an array"),
    ],
)
def test_wrong_arrays_are_one_error(given, error, words):
    with pytest.raises(error, match=words):
        ik.solve_contact_problems(*given)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"restitution": 1.2}, ik.errors.RangeError, "restitution must be 0 to 1, got 1.2"),
        ({"friction": [-1.0]}, ik.errors.RangeError, "friction"),
        ({"friction": [0.1, 0.2]}, ik.errors.ShapeError, "friction"),
        ({"before": np.zeros((2, 3))}, ik.errors.ShapeError, "before"),
        ({"law": ik.Law("lzb")}, ik.errors.InputError, "lzb"),
        ({"threads": 0}, ik.errors.RangeError, "threads"),
    ],
)
def test_wrong_coefficients_are_one_error(given, error, words):
    with pytest.raises(error, match=words):
        ik.solve_contact_problems(W, FREE, **given)
