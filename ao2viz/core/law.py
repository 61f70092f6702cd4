"""Laws: what an action does in general, one polynomial of the observation for each action.

A law is fitted to the experience of all options together. What an option has experienced itself is
then kept beside it as the exception that it is: predictions add what the options around a place
saw happen differently. What is left over is far less curved than what happens, so planes through
a few options follow it far better.
"""

from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled

MAX_DEGREE = 3
# A law may have one term for so many options that tried the action.
_OPTIONS_A_TERM = 8
# So many terms at the most, whatever the number of features.
_MAX_TERMS = 500
# Steadies the terms that hardly vary, as a fraction of the experience that there is.
_RIDGE = 1e-6


class Law(NamedTuple):
    """What each of A actions does, by D features; `T` terms at the most.

    The terms are 1, then each feature, then the products of two, then of three: those of the gaps
    between the (scaled) state and the centre.
    """

    centre: NDArray[np.float64]  # [D] the mean of where the actions were tried.
    coefficients: NDArray[np.float64]  # [A, T, D] of the displacement, 0 past an action's terms.
    n_terms: NDArray[np.int64]  # [A] terms in use; 0: there is no law yet.
    terms: NDArray[np.float64]  # [T] work space.


def allocate_law(n_actions: int, n_features: int, degree: int) -> Law:
    """No law yet, with room for polynomials of this degree, or of what there is room for."""
    while degree > 1 and count_terms(n_features, degree) > _MAX_TERMS:
        degree -= 1
    room = count_terms(n_features, degree) if degree > 0 else 0
    return Law(
        np.zeros(n_features),
        np.zeros((n_actions, room, n_features)),
        np.zeros(n_actions, np.int64),
        np.zeros(room),
    )


def count_terms(n_features: int, degree: int) -> int:
    """Terms of a polynomial of this degree in so many features."""
    return comb(n_features + degree, degree)


def choose_terms(n_features: int, room: int, tried: int) -> int:
    """How many terms so many options that tried an action are enough for; 0: not even a plane."""
    chosen = 0
    for degree in range(1, MAX_DEGREE + 1):
        terms = count_terms(n_features, degree)
        if terms <= room and terms * _OPTIONS_A_TERM <= tried:
            chosen = terms
    return chosen


@compiled
def write_terms(state: NDArray[np.float64], law: Law, n_terms: int) -> None:
    """Writes the first terms at a (scaled) state [D] into the law's work space."""
    n_features, terms, centre = state.shape[0], law.terms, law.centre
    terms[0] = 1.0
    for i in range(n_features):
        terms[1 + i] = state[i] - centre[i]
    n = 1 + n_features
    first = n  # Of the products of two.
    if n < n_terms:
        for i in range(n_features):
            for j in range(i, n_features):
                terms[n] = terms[1 + i] * terms[1 + j]
                n += 1
    if n < n_terms:
        two = first
        for i in range(n_features):
            for j in range(i, n_features):
                for k in range(j, n_features):
                    terms[n] = terms[two] * terms[1 + k]
                    n += 1
                two += 1


@compiled
def add_displacement(
    law: Law, action: int, state: NDArray[np.float64], sum_: NDArray[np.float64]
) -> None:
    """Adds what the law says that an action does at a (scaled) state to the first D of `sum_`."""
    n_terms = law.n_terms[action]
    if n_terms == 0:
        return
    write_terms(state, law, n_terms)
    for n in range(n_terms):
        term = law.terms[n]
        for d in range(state.shape[0]):
            sum_[d] += term * law.coefficients[action, n, d]


@compiled
def fit_law(
    law: Law,
    action: int,
    n_terms: int,
    origins: NDArray[np.float64],
    displacements: NDArray[np.float64],
    loads: NDArray[np.float64],
) -> None:
    """Fits an action's law by least squares to `n` displacements [n, D] from origins [n, D].

    `loads` [n] says how much each counts. With 0 terms the action has no law.
    """
    n_features = origins.shape[1]
    law.coefficients[action] = 0.0
    law.n_terms[action] = n_terms
    if n_terms == 0:
        return
    normal = np.zeros((n_terms, n_terms))
    right = np.zeros((n_terms, n_features))
    for row in range(origins.shape[0]):
        write_terms(origins[row], law, n_terms)
        for i in range(n_terms):
            loaded = loads[row] * law.terms[i]
            for j in range(i + 1):
                normal[i, j] += loaded * law.terms[j]
            for d in range(n_features):
                right[i, d] += loaded * displacements[row, d]
    _solve(normal, right, _RIDGE * loads.sum())
    law.coefficients[action, :n_terms] = right


@compiled
def _solve(normal: NDArray[np.float64], right: NDArray[np.float64], ridge: float) -> None:
    """Solves (normal + ridge) x = right in place, by Cholesky; reads the lower triangle.

    Written out so that the sums are taken in the same order on every machine.
    """
    n = normal.shape[0]
    for j in range(n):
        pivot = normal[j, j] + ridge
        for k in range(j):
            pivot -= normal[j, k] * normal[j, k]
        normal[j, j] = np.sqrt(max(pivot, ridge))
        for i in range(j + 1, n):
            s = normal[i, j]
            for k in range(j):
                s -= normal[i, k] * normal[j, k]
            normal[i, j] = s / normal[j, j]
    for d in range(right.shape[1]):
        for i in range(n):
            s = right[i, d]
            for k in range(i):
                s -= normal[i, k] * right[k, d]
            right[i, d] = s / normal[i, i]
        for i in range(n - 1, -1, -1):
            s = right[i, d]
            for k in range(i + 1, n):
                s -= normal[k, i] * right[k, d]
            right[i, d] = s / normal[i, i]
