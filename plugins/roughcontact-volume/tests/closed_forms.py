"""Closed forms of elastic bodies with eigenstrains, each proved by itself in test_closed_forms.py.

Strains are symmetric 3 x 3 tensors, lengths have any unit, z points into the body from the surface z = 0.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from scipy import integrate

Array = npt.NDArray[np.float64]
PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def as_tensor(components: Sequence[float] | Array) -> Array:
    """Return a tensor by its components xx, yy, zz, yz, xz, xy."""
    tensor = np.zeros((3, 3))
    for (i, j), value in zip(PAIRS, components, strict=True):
        tensor[i, j] = tensor[j, i] = value
    return tensor


def as_components(tensor: Array) -> Array:
    return np.array([tensor[i, j] for i, j in PAIRS])


def apply_hooke(strain: Array, young: float, poisson: float) -> Array:
    """Return the stress of an elastic strain."""
    shear = young / (2.0 * (1.0 + poisson))
    return 2.0 * shear * (strain + poisson / (1.0 - 2.0 * poisson) * np.trace(strain) * np.eye(3))


def find_eshelby(axes: Sequence[float], poisson: float) -> Array:
    """Return Eshelby's tensor, shape (3, 3, 3, 3), of an ellipsoid with semi-axes along x, y, z.

    Inside, an eigenstrain e gives the strain S e. Eshelby, Proc. R. Soc. Lond. A 241 (1957) 376,
    https://doi.org/10.1098/rspa.1957.0133; Mura, Micromechanics of Defects in Solids (1987), sec. 11.
    """
    square = np.asarray(axes, dtype=np.float64) ** 2
    volume = 2.0 * math.pi * math.sqrt(math.prod(square))

    def integrate_over(*over: int) -> float:
        def rate(s: float) -> float:
            below = math.prod(square[i] + s for i in over) * math.sqrt(math.prod(square + s))
            return volume / float(below)

        scale = float(square.max())
        near = integrate.quad(rate, 0.0, scale, epsabs=0.0, epsrel=1e-12)[0]
        far = integrate.quad(lambda t: rate(scale / t**2) * 2.0 * scale / t**3, 0.0, 1.0, epsabs=0.0, epsrel=1e-12)[0]
        return float(near + far)

    single = [integrate_over(i) for i in range(3)]
    tensor = np.zeros((3, 3, 3, 3))
    factor = 1.0 / (8.0 * math.pi * (1.0 - poisson))
    for i in range(3):
        for j in range(3):
            double = integrate_over(i, j)
            if i == j:
                tensor[i, i, i, i] = factor * (3.0 * square[i] * double + (1.0 - 2.0 * poisson) * single[i])
                continue
            tensor[i, i, j, j] = factor * (square[j] * double - (1.0 - 2.0 * poisson) * single[i])
            shear = (square[i] + square[j]) * double + (1.0 - 2.0 * poisson) * (single[i] + single[j])
            tensor[i, j, i, j] = tensor[i, j, j, i] = 0.5 * factor * shear
    return tensor


def find_inhomogeneity_strain(
    axes: Sequence[float], inside: tuple[float, float], outside: tuple[float, float], far: Array
) -> Array:
    """Return the strain in an ellipsoid of other moduli (Young, Poisson) under a uniform strain far from it."""
    basis = [as_tensor(row) for row in np.eye(6)]

    def as_matrix(act: Callable[[Array], Array]) -> Array:
        return np.array([as_components(act(one)) for one in basis]).T

    eshelby = find_eshelby(axes, outside[1])
    spread = as_matrix(lambda e: np.einsum("ijkl,kl", eshelby, e))
    body = as_matrix(lambda e: apply_hooke(e, *outside))
    own = as_matrix(lambda e: apply_hooke(e, *inside))
    # C_i (far + S e) = C (far + S e - e)
    eigenstrain = np.linalg.solve((own - body) @ spread + body, (body - own) @ as_components(far))
    return as_tensor(as_components(far) + spread @ eigenstrain)


# Derivatives of the triple antiderivatives, over x, y, z, of 1/r (harmonic) and r (biharmonic).
def _harmonic(x: Array, i: int, j: int) -> Array:
    r = np.sqrt((x**2).sum(axis=0))
    if i != j:
        k = 3 - i - j
        return _logarithm(x, k, r)
    j, k = (i + 1) % 3, (i + 2) % 3
    return -np.arctan(x[j] * x[k] / (x[i] * r))


def _logarithm(x: Array, k: int, r: Array) -> Array:
    """Return log(x_k + r) without cancellation."""
    rest = r**2 - x[k] ** 2
    return np.where(x[k] < 0.0, np.log(np.maximum(rest, 1e-300)) - np.log(r - x[k]), np.log(np.abs(x[k]) + r))


def _biharmonic(x: Array, indices: tuple[int, ...]) -> Array:
    r = np.sqrt((x**2).sum(axis=0))
    counts = [indices.count(axis) for axis in range(3)]
    order = sorted(range(3), key=lambda axis: -counts[axis])
    i, j, k = order
    powers = tuple(counts[axis] for axis in order)
    product = x[0] * x[1] * x[2]
    if powers == (2, 1, 1):
        return x[i] / r
    if powers == (2, 2, 0):
        return -product / ((x[i] ** 2 + x[j] ** 2) * r)
    if powers == (3, 1, 0):
        return _logarithm(x, k, r) - x[i] ** 2 * x[k] / ((x[i] ** 2 + x[j] ** 2) * r)
    both = [_biharmonic(x, (i, i, other, other)) for other in (j, k)]
    return 2.0 * _harmonic(x, i, i) - both[0] - both[1]


def _sum_corners(box: Array, point: Array, of: Callable[[Array], Array]) -> Array:
    """Return the integral over a box, by its antiderivative at the corners, around points of shape (3, ...)."""
    total = np.zeros(point.shape[1:])
    for ends in itertools.product((0, 1), repeat=3):
        corner = np.array([box[axis, end] for axis, end in enumerate(ends)])
        sign = (-1.0) ** sum(ends)
        total += sign * of(point - corner.reshape(3, *[1] * (point.ndim - 1)))
    return total


def find_cuboid_strain(box: Array, eigenstrain: Array, poisson: float, point: Array) -> Array:
    """Return the strain, shape (3, 3, ...), at points, shape (3, ...), by a uniform eigenstrain in a cuboid.

    The body is infinite; `box` has the ends along x, y, z, shape (3, 2). With the potentials phi and psi, the integrals
    of 1/r and r over the cuboid, 8 pi (1 - nu) u_i = psi_,ijk e_jk - 2 nu e_kk phi_,i - 4 (1 - nu) e_ij phi_,j.
    Chiu, J. Appl. Mech. 44 (1977) 587-590.
    """
    phi = {}
    psi = {}
    for i, j in itertools.combinations_with_replacement(range(3), 2):
        phi[i, j] = phi[j, i] = _sum_corners(box, point, lambda x, i=i, j=j: _harmonic(x, i, j))
    for four in itertools.combinations_with_replacement(range(3), 4):
        psi[four] = _sum_corners(box, point, lambda x, four=four: _biharmonic(x, four))
    gradient = np.zeros((3, 3, *point.shape[1:]))
    trace = float(np.trace(eigenstrain))
    for i, m in itertools.product(range(3), repeat=2):
        for j, k in itertools.product(range(3), repeat=2):
            gradient[i, m] += psi[tuple(sorted((i, j, k, m)))] * eigenstrain[j, k]
        gradient[i, m] -= 2.0 * poisson * trace * phi[i, m]
        for j in range(3):
            gradient[i, m] -= 4.0 * (1.0 - poisson) * eigenstrain[i, j] * phi[j, m]
    gradient /= 8.0 * math.pi * (1.0 - poisson)
    return 0.5 * (gradient + gradient.swapaxes(0, 1))


def find_cuboid_stress(box: Array, eigenstrain: Array, young: float, poisson: float, point: Array) -> Array:
    """Return the stress, shape (3, 3, ...), of `find_cuboid_strain`."""
    inside = np.all([(point[axis] > box[axis, 0]) & (point[axis] < box[axis, 1]) for axis in range(3)], axis=0)
    elastic = find_cuboid_strain(box, eigenstrain, poisson, point)
    elastic = elastic - np.multiply.outer(eigenstrain, inside.astype(np.float64))
    shear = young / (2.0 * (1.0 + poisson))
    volume = poisson / (1.0 - 2.0 * poisson) * np.trace(elastic)
    return 2.0 * shear * (elastic + np.multiply.outer(np.eye(3), volume))


def mirror(tensor: Array) -> Array:
    """Return a tensor as the surface z = 0 mirrors it."""
    turn = np.diag([1.0, 1.0, -1.0])
    return turn @ tensor @ turn


def find_half_space_stress(
    box: Array, eigenstrain: Array, young: float, poisson: float, point: Array, nodes: int = 160
) -> Array:
    """Return the stress, shape (3, 3), at one point by a uniform eigenstrain in a cuboid below a free surface.

    As Chiu, J. Appl. Mech. 45 (1978) 302-306: a mirrored cuboid removes the shear at the surface and doubles the normal
    traction, which Boussinesq's point forces then remove, here by quadrature.
    """
    image = np.array([box[0], box[1], -box[2, ::-1]])
    pair = ((box, eigenstrain), (image, mirror(eigenstrain)))
    stress = sum(find_cuboid_stress(b, e, young, poisson, point[:, np.newaxis])[..., 0] for b, e in pair)
    depth = float(point[2])
    # Nodes that are dense above the cuboid and above the point; the traction decays with the cube of the distance.
    scale = 0.5 * (depth + float(box[2, 0]))
    s, step = np.linspace(-6.0, 6.0, nodes, retstep=True)
    ends = scale * np.sinh(s)
    weights = scale * np.cosh(s) * step
    x = point[0] + ends[:, np.newaxis] + 0.0 * ends
    y = point[1] + ends + 0.0 * ends[:, np.newaxis]
    at = np.array([x, y, np.zeros_like(x)])
    traction = sum(find_cuboid_stress(b, e, young, poisson, at)[2, 2] for b, e in pair)
    away = np.array([point[0] - x, point[1] - y, np.full_like(x, depth)])
    return np.asarray(
        stress + np.einsum("ijxy,xy,x,y->ij", find_boussinesq_stress(away, poisson), traction, weights, weights)
    )


def find_boussinesq_stress(x: Array, poisson: float) -> Array:
    """Return the stress, shape (3, 3, ...), by a unit normal force that presses at the origin of the surface.

    Johnson, Contact Mechanics (1985), sec. 3.2, https://doi.org/10.1017/CBO9781139171731
    """
    r = np.sqrt((x**2).sum(axis=0))
    z = x[2]
    below = r * (r + z)
    flat = 1.0 - 2.0 * poisson
    stress = np.zeros((3, 3, *r.shape))
    for i, j in itertools.product(range(3), repeat=2):
        stress[i, j] = -3.0 * x[i] * x[j] * z / r**5
        if i < 2 and j < 2:
            own = 1.0 / below - z / r**3 if i == j else 0.0
            stress[i, j] += flat * (x[i] * x[j] * (2.0 * r + z) / (r**3 * (r + z) ** 2) - own)
    return stress / (2.0 * math.pi)


def find_cuboid_displacement(
    box: Array, eigenstrain: Array, poisson: float, x: Array, y: Array, order: int = 12
) -> Array:
    """Return how far the free surface moves into the body by a uniform eigenstrain in a cuboid below it.

    By Betti's theorem it is the integral over the cuboid of Boussinesq's stress times the eigenstrain, by Gauss's rule.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    total = np.zeros(np.broadcast(x, y).shape)
    lengths = 0.5 * (box[:, 1] - box[:, 0])
    middle = box.mean(axis=1)
    for places in itertools.product(range(order), repeat=3):
        at = middle + lengths * nodes[list(places)]
        away = np.array([at[0] - x + 0.0 * y, at[1] - y + 0.0 * x, at[2] + np.zeros(total.shape)])
        work = np.einsum("ij...,ij->...", find_boussinesq_stress(away, poisson), eigenstrain)
        total += float(np.prod(weights[list(places)] * lengths)) * work
    return total


def find_dilating_sphere(radius: float, depth: float, strain: float, poisson: float, point: Array) -> Array:
    """Return the displacement, shape (3, ...), outside a sphere that dilates by a strain below a free surface.

    With phi = V/r and phi' that of the mirrored sphere, -4 pi (1 - nu) u / (1 + nu) e is
    grad phi + (3 - 4 nu) grad phi' + 2 z grad phi'_z - 2 (3 - 4 nu) phi'_z along z.
    Mindlin, Cheng, J. Appl. Phys. 21 (1950) 931-933.
    """
    volume = 4.0 / 3.0 * math.pi * radius**3
    from_sphere = np.array([point[0], point[1], point[2] - depth])
    from_image = np.array([point[0], point[1], point[2] + depth])
    r, s = (np.sqrt((x**2).sum(axis=0)) for x in (from_sphere, from_image))
    k = 3.0 - 4.0 * poisson
    gradient_z = 3.0 * from_image * from_image[2] / s**5
    gradient_z[2] -= 1.0 / s**3
    found = -from_sphere / r**3 - k * from_image / s**3 + 2.0 * point[2] * gradient_z
    found[2] += 2.0 * k * from_image[2] / s**3
    return np.asarray(-(1.0 + poisson) * strain * volume / (4.0 * math.pi * (1.0 - poisson)) * found)


def find_sphere_heave(radius: float, depth: float, strain: float, poisson: float, x: Array, y: Array) -> Array:
    """Return how far the surface moves into the body above a dilating sphere: -(1 + nu)/pi V e c/R^3."""
    volume = 4.0 / 3.0 * math.pi * radius**3
    distance = np.sqrt(x**2 + y**2 + depth**2)
    return np.asarray(-(1.0 + poisson) / math.pi * volume * strain * depth / distance**3)
