"""Independent solutions: the boundary-value problem with many digits, and an axisymmetric contact by rings."""

import mpmath as mp
import numpy as np
import roughcontact as rc
from scipy import optimize, special


def boundary_values(layers, substrate, q, digits=60):
    """Return q u / p from Airy's stress function with four constants per layer, all interfaces at once."""
    with mp.workdps(digits):
        q, count = mp.mpf(q), len(layers)
        # On a rigid base the last displacement vanishes, and there is nothing below.
        is_rigid = isinstance(substrate, rc.Rigid)
        size = 4 * count + (0 if is_rigid else 2)
        depths = [q * mp.mpf(layer.thickness) for layer in layers]

        def wave(body, z, sign):
            poisson, shear = mp.mpf(body.poisson), mp.mpf(body.young) / 2 / (1 + mp.mpf(body.poisson))
            e, columns = mp.exp(sign * z), []
            for phi in (
                (e, sign * e, e, sign * e),
                (z * e, (1 + sign * z) * e, (2 * sign + z) * e, (3 + sign * z) * e),
            ):
                along = ((1 - poisson) * phi[2] + poisson * phi[0]) / (2 * shear)
                slope = ((1 - poisson) * phi[3] + poisson * phi[1]) / (2 * shear)
                columns.append((along, slope - phi[1] / shear, phi[1], -phi[0]))
            return columns

        def columns(i, z):
            if i == count:
                return wave(substrate, mp.mpf(0), -1)
            return wave(layers[i], z, -1) + wave(layers[i], z - depths[i], 1)

        matrix, right = mp.matrix(size), mp.matrix(size, 1)
        top = columns(0, mp.mpf(0))
        for j in range(4):
            matrix[0, j], matrix[1, j] = top[j][2], top[j][3]
        right[1] = -1
        for i in range(count):
            held = is_rigid and i == count - 1
            above, below = columns(i, depths[i]), [] if held else columns(i + 1, mp.mpf(0))
            for part in range(2 if held else 4):
                row = 2 + 4 * i + part
                for j, column in enumerate(above):
                    matrix[row, 4 * i + j] = column[part]
                for j, column in enumerate(below):
                    matrix[row, 4 * i + 4 + j] = -column[part]
        found = mp.lu_solve(matrix, right)
        return mp.fsum(found[j] * top[j][1] for j in range(4))


def one_layer(layer, substrate, q):
    """Return q u / p of one bonded layer: O'Sullivan and King (1988), as in Nogi and Kato (1997).

    alpha(q) = 1 + 4 q h kappa theta - lambda kappa theta^2 over 1 - (lambda + kappa + 4 kappa (q h)^2) theta
    + lambda kappa theta^2, theta = exp(-2 q h).
    """
    nu1, nu2 = layer.poisson, substrate.poisson
    m1, m2 = layer.young / 2 / (1 + nu1), substrate.young / 2 / (1 + nu2)
    ratio = m1 / m2
    kappa = (ratio - 1) / (ratio + 3 - 4 * nu1)
    lam = 1 - 4 * (1 - nu1) / (1 + ratio * (3 - 4 * nu2))
    x = q * layer.thickness
    theta = np.exp(-2 * x)
    above = 1 + 4 * x * kappa * theta - lam * kappa * theta**2
    below = 1 - (lam + kappa + 4 * kappa * x**2) * theta + lam * kappa * theta**2
    return 2 * layer.compliance * above / below


def layer_on_rigid_base(layer, q):
    """Return q u / p of one layer bonded to a rigid base: from the same problem, solved by hand.

    The fraction of the half-space's is (2 k sinh 2x - 4x) / (2 k cosh 2x + 4 x^2 + 1 + k^2), k = 3 - 4 nu, x = q h.
    """
    with mp.workdps(50):
        k = 3 - 4 * mp.mpf(layer.poisson)
        x = mp.mpf(q) * mp.mpf(layer.thickness)
        above = 2 * k * mp.sinh(2 * x) - 4 * x
        below = 2 * k * mp.cosh(2 * x) + 4 * x**2 + 1 + k**2
        return 2 * layer.compliance * float(above / below)


def sphere_by_rings(response, modulus, radius, contact):
    """Return force and approach of a rigid paraboloid whose contact has a radius; see `series_by_rings`."""
    coefficients, approach = series_by_rings(response, modulus, radius, contact)
    return 2 * np.pi * contact**2 * sum(c / (2 * k + 1) for k, c in enumerate(coefficients, 1)), approach


def series_by_rings(response, modulus, radius, contact):
    """Return the pressure of a rigid paraboloid whose contact has a radius, by a Galerkin series, and the approach.

    The pressure is the sum of c_k (1 - (r/a)^2)^(k - 1/2): Hankel's transforms of these are known (Sneddon), and
    the displacement is that of the paraboloid at Gauss points in r. A term singular at the edge is absent.
    """
    terms = 10
    # Waves up to 200/a, in panels: what the layer adds falls as exp(-2 q h).
    edges = np.linspace(0, 200, 201)
    at, w = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (at + 1)).ravel()
    w = (half * w).ravel()
    orders = np.arange(1, terms + 1) + 0.5
    transforms = [2 ** (v - 1) * special.gamma(v) * special.jv(v, s) / s**v for v in orders]
    extra = response(s / contact) * s / contact * modulus / 2 - 1.0
    r = np.cos(np.pi * (np.arange(40) + 0.5) / 80)
    j0 = special.j0(np.outer(r, s))
    # u(r) = integral of p(s) u(s) J0 s ds; the half-space's part of each term is a known polynomial in r^2.
    system = np.empty((r.size, terms + 1))
    for k, transform in enumerate(transforms, 1):
        smooth = j0 @ (w * extra * transform)
        power = [half_space(k, radius_) for radius_ in r]
        system[:, k - 1] = 2 * contact / modulus * (smooth + np.array(power))
    system[:, terms] = -1.0
    system[:, terms] *= -system[:, 0].max()
    unit = system[:, 0].max()
    found = np.linalg.lstsq(system / unit, -(r**2) * contact**2 / (2 * radius * unit), rcond=None)[0]
    return found[:-1], -unit * found[-1]


def stress_of_waves(layers, substrate, q, depth, number):
    """Return the stress along, across, normal and shear by waves of unit pressure, in a layer, from Airy's function.

    All constants come from one linear system for each wave: four for each layer, two for the half-space below.
    """
    is_rigid = isinstance(substrate, rc.Rigid)
    bodies = [*layers, substrate]
    count = len(layers)
    size = 4 * count + (0 if is_rigid else 2)

    def columns(i, z):
        """Return displacements, tractions and the stress along of the functions of a body, at a depth below its top."""
        body = bodies[i]
        shear = body.young / (2 * (1 + body.poisson))
        found = []
        for sign in (-1,) if i == count else (-1, 1):
            place = q * z if sign < 0 else q * (z - layers[i].thickness)
            e = np.exp(sign * place)
            for phi in (
                (e, sign * e, e, sign * e),
                (place * e, (1 + sign * place) * e, (2 * sign + place) * e, (3 + sign * place) * e),
            ):
                along = ((1 - body.poisson) * phi[2] + body.poisson * phi[0]) / (2 * shear)
                slope = ((1 - body.poisson) * phi[3] + body.poisson * phi[1]) / (2 * shear)
                found.append((along, slope - phi[1] / shear, phi[1], -phi[0], phi[2]))
        return np.array(found)

    scale = bodies[0].young
    weights = np.array([scale, scale, 1.0, 1.0])[:, None, None]
    matrix = np.zeros((size, size, q.size))
    matrix[:2, : columns(0, 0.0).shape[0]] = columns(0, 0.0)[:, 2:4].transpose(1, 0, 2)
    for i in range(count):
        above = columns(i, layers[i].thickness)
        if is_rigid and i == count - 1:
            matrix[2 + 4 * i :, 4 * i :] = weights[:2] * above[:, :2].transpose(1, 0, 2)
            break
        below = columns(i + 1, 0.0)
        rows = slice(2 + 4 * i, 6 + 4 * i)
        matrix[rows, 4 * i : 4 * i + 4] = weights * above[:, :4].transpose(1, 0, 2)
        matrix[rows, 4 * i + 4 : 4 * i + 4 + below.shape[0]] = -weights * below[:, :4].transpose(1, 0, 2)
    right = np.zeros((q.size, size, 1))
    right[:, 1] = -1.0
    constants = np.linalg.solve(matrix.transpose(2, 0, 1), right)[..., 0].T
    top = sum(layer.thickness for layer in layers[:number])
    own = columns(number, depth - top)
    part = constants[4 * number : 4 * number + own.shape[0]]
    _, _, shear, normal, along = np.einsum("kn,kcn->cn", part, own)
    return along, bodies[number].poisson * (along + normal), normal, shear


def von_mises_below_sphere(kernel, series, contact, depth, number, r):
    """Return the von Mises stress by an axisymmetric pressure at radii, from Hankel's integrals over the waves."""
    edges = np.linspace(0, 120, 241)
    at, w = np.polynomial.legendre.leggauss(10)
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (at + 1)).ravel()
    w = (half * w).ravel()
    orders = np.arange(1, series.size + 1) + 0.5
    pressure = sum(
        c * 2 ** (v - 1) * special.gamma(v) * special.jv(v, s) / s**v for c, v in zip(series, orders, strict=True)
    )
    along, across, normal, shear = stress_of_waves(kernel.layers, kernel.substrate, s / contact, depth, number)
    place = np.outer(r / contact, s)
    weight = w * s * pressure
    j0, j1, j2 = (special.jv(n, place) for n in range(3))
    mean = j0 @ (weight * (along + across))
    difference = -j2 @ (weight * (along - across))
    radial, hoop = 0.5 * (mean + difference), 0.5 * (mean - difference)
    axial = j0 @ (weight * normal)
    shear = j1 @ (weight * shear)
    return np.sqrt(0.5 * ((radial - hoop) ** 2 + (hoop - axial) ** 2 + (axial - radial) ** 2) + 3 * shear**2)


def half_space(k, r):
    """Integral over s of J0(s r) times the transform of (1 - r^2)^(k - 1/2): Weber and Schafheitlin."""
    return 0.5 * special.gamma(k + 0.5) * np.sqrt(np.pi) / special.gamma(k + 1) * special.hyp2f1(0.5, -k, 1, r * r)


def stroh_compliance(stiffness, normal, x_axis, angle):
    """Return half of q u / p by Stroh's eigenvalue problem, for a wave at an angle from the x axis.

    Amplitudes y = (u, t) of waves exp(i q m.x) that decay downwards: the eigenvectors of N with Im p > 0, -z along n.
    """
    n, x = (np.array(side, dtype=float) / np.linalg.norm(side) for side in (normal, x_axis))
    m = np.cos(angle) * x + np.sin(angle) * np.cross(n, x)
    index = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    scale = np.max(stiffness)
    tensor = np.array(stiffness)[index[:, :, None, None], index] / scale
    # Into the body.
    n = -n
    q, r, t = (np.einsum("ijkl,j,l->ik", tensor, a, b) for a, b in ((m, m), (m, n), (n, n)))
    inverse = np.linalg.inv(t)
    matrix = np.block([[-inverse @ r.T, inverse], [r @ inverse @ r.T - q, -r @ inverse]])
    values, vectors = np.linalg.eig(matrix)
    below = vectors[:, values.imag > 0.0]
    # u = A f, traction on the surface with normal n: i q B f.
    admittance = below[:3] @ np.linalg.inv(below[3:])
    return 0.5 * float((n @ (1j * admittance) @ n).real) / scale


def hertz_ellipse(modulus, radii, force):
    """Return semi-axes, approach and maximum pressure of a rigid paraboloid on a body with E* by direction.

    Hertz's pressure over an ellipse displaces the surface by a paraboloid: the Fourier integral over the radius of a
    wave vector is known, that over its angle is a trapezoidal sum, and the ratio of the axes a bisection.
    """
    angles = np.pi / 20000 * np.arange(20000)
    compliance = 1.0 / modulus(angles)
    cos, sin = np.cos(angles) ** 2, np.sin(angles) ** 2

    def sums(ratio):
        width = np.sqrt(cos + ratio**2 * sin)
        return (np.mean(compliance * part / width**power) for part, power in ((1.0, 1), (cos, 3), (sin, 3)))

    def excess(logarithm):
        _, x, y = sums(np.exp(logarithm))
        return np.log(y * radii[1] / (x * radii[0]))

    ratio = np.exp(optimize.brentq(excess, -3.0, 3.0, xtol=1e-14))
    depth, bend, _ = sums(ratio)
    along = (1.5 * force * radii[0] * bend) ** (1 / 3)
    peak = 1.5 * force / (np.pi * ratio * along**2)
    return (along, ratio * along), 0.75 * force * depth / along, peak
