"""Anisotropic materials: their stiffness, and how they lie under the surface."""

from __future__ import annotations

import math
from typing import ClassVar, Self, TypeAlias

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.directions import DirectionSeries, expand_directions
from roughcontact_layered.stack import Array

Vector: TypeAlias = tuple[float, float, float]
Matrix: TypeAlias = tuple[tuple[float, ...], ...]

# Relative errors of typed values: by how much a stiffness may differ from its transpose, and the cosine of the angle
# between the normal and the x axis from zero.
_SYMMETRY_TOLERANCE = 1e-6
_ORTHOGONALITY_TOLERANCE = 1e-6
# Smallest over largest eigenvalue of a stiffness, below which rounding decides whether it is positive.
_MIN_EIGENVALUE_RATIO = 1e-10
# Places of the six components xx, yy, zz, yz, xz, xy in the tensor (Voigt's notation).
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


def _numbers(value: object, shape: tuple[int, ...]) -> Array | None:
    """Return finite numbers of a shape; None if the value is something else."""
    try:
        array = np.array(value)
    except ValueError:
        return None
    is_real = array.shape == shape and array.dtype.kind in "fiu" and not np.ma.is_masked(value)
    return array.astype(np.float64) if is_real and np.isfinite(array).all() else None


def _stiffness(value: object) -> Matrix:
    matrix = _numbers(value, (6, 6))
    if matrix is None:
        raise rc.InputError.about("The stiffness", value, "6 rows of 6 finite numbers (Pa), for xx, yy, zz, yz, xz, xy")
    largest = np.abs(matrix).max()
    if np.abs(matrix - matrix.T).max() > _SYMMETRY_TOLERANCE * largest:
        raise rc.InputError(
            "The stiffness is not symmetric: C_ij and C_ji must be equal, in the order xx, yy, zz, yz, xz, xy."
        )
    matrix = 0.5 * (matrix + matrix.T)
    eigenvalues = np.linalg.eigvalsh(matrix)
    if not eigenvalues[0] > _MIN_EIGENVALUE_RATIO * eigenvalues[-1]:
        raise rc.InputError(
            "The stiffness is not positive definite, so that some strain would release energy (eigenvalues "
            f"{eigenvalues[0]:g} to {eigenvalues[-1]:g} Pa): check its values and their order, xx, yy, zz, yz, xz, xy."
        )
    return tuple(tuple(row) for row in matrix.tolist())


def _direction(value: object, what: str) -> Vector:
    vector = _numbers(value, (3,))
    length = 0.0 if vector is None else float(np.linalg.norm(vector))
    if vector is None or not length > 0.0:
        raise rc.InputError.about(what, value, "three numbers, not all zero, such as (1, 1, 1)")
    x, y, z = vector.tolist()
    return x, y, z


def _normal(value: object) -> Vector:
    return _direction(value, "The normal of the surface")


def _x_axis(value: object) -> Vector:
    return _direction(value, "The x axis")


def _modulus(value: float) -> float:
    return rc.Elastic(value, 0.0).young


def _coupling(value: float) -> float:
    number = _numbers(value, ())
    if number is None:
        raise rc.InputError.about("The constant c12 or c13", value, "a finite number (Pa)")
    return float(number)


@attrs.frozen
class Anisotropic(rc.Material):
    """A crystal, a fibre composite or wood: any linear elastic half-space, with its orientation.

    Take it together with `AnisotropicKernel`, which knows that its response depends on the direction; all other kernels
    take the mean over the directions, and the compliance is this mean.

    Parameters
    ----------
    stiffness
        Stiffness C in the axes of the crystal, 6 rows of 6, Pa, for strains xx, yy, zz, yz, xz, xy (the shears twice
        the components of the tensor): symmetric and positive definite.
    normal
        Outward normal of the surface in the axes of the crystal, such as (1, 1, 0).
    x_axis
        Direction in the crystal that lies along x of the grid, perpendicular to the normal.

    Raises
    ------
    roughcontact.InputError
        If the stiffness is not symmetric or not positive definite, or the directions are not perpendicular.

    Examples
    --------
    Silicon, of which the surface is cut along a cube face, a face diagonal and across the body diagonal:

    >>> for normal, x_axis in [((0, 0, 1), (1, 1, 0)), ((1, 1, 0), (0, 0, 1)), ((1, 1, 1), (1, -1, 0))]:
    ...     silicon = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=normal, x_axis=x_axis)
    ...     print(f"{1e-9 / silicon.compliance:.1f} GPa")
    164.8 GPa
    172.8 GPa
    175.3 GPa
    """

    is_isotropic: ClassVar[bool] = False

    stiffness: Matrix = attrs.field(converter=_stiffness)
    normal: Vector = attrs.field(default=(0.0, 0.0, 1.0), converter=_normal)
    x_axis: Vector = attrs.field(default=(1.0, 0.0, 0.0), converter=_x_axis)

    def __attrs_post_init__(self) -> None:
        normal, x = (np.array(side) / np.linalg.norm(side) for side in (self.normal, self.x_axis))
        if abs(float(normal @ x)) > _ORTHOGONALITY_TOLERANCE:
            raise rc.InputError(
                f"The x axis {self.x_axis} does not lie in the surface with normal {self.normal}: choose directions "
                "with a scalar product of zero."
            )

    @classmethod
    def cubic(
        cls, c11: float, c12: float, c44: float, *, normal: object = (0.0, 0.0, 1.0), x_axis: object = (1.0, 0.0, 0.0)
    ) -> Self:
        """Return a cubic crystal with three constants, Pa, in the axes of its cube.

        Raises
        ------
        roughcontact.InputError
            As for the class.
        """
        shear = [_modulus(c44)] * 3
        axial = np.full((3, 3), _coupling(c12))
        np.fill_diagonal(axial, _modulus(c11))
        return cls(_blocks(axial, shear), normal, x_axis)

    @property
    def compliance(self) -> float:
        """Half the mean over the directions of q u / p, 1/Pa: its inverse is the indentation modulus."""
        return self.directions.mean

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf

    @property
    def directions(self) -> DirectionSeries:
        """The compliance of waves by the direction of their wave vector."""
        normal, x = (np.array(side) / np.linalg.norm(side) for side in (self.normal, self.x_axis))
        x = x - (x @ normal) * normal
        axes = np.array([x, np.cross(normal, x), normal])
        tensor = np.array(self.stiffness)[_VOIGT[:, :, np.newaxis, np.newaxis], _VOIGT]
        turned = np.einsum("ia,jb,kc,ld,abcd->ijkl", axes, axes, axes, axes, tensor, optimize=True)
        return expand_directions(turned.tobytes())


@attrs.frozen
class TransverselyIsotropic(rc.Material):
    r"""A half-space that is isotropic in its surface, such as a hexagonal crystal or wood cut across the fibres.

    All waves have the same modulus, so that Love's kernel, the default, is exact with

    .. math:: E^* = 2 \sqrt{\frac{c_{11} c_{33} - c_{13}^2}{c_{11}}
              \left(\frac{1}{c_{44}} + \frac{2}{\sqrt{c_{11} c_{33}} + c_{13}}\right)^{-1}}

    Parameters
    ----------
    c11, c12, c13, c33, c44
        Stiffness, Pa, with the axis 3 along the normal of the surface.

    Raises
    ------
    roughcontact.InputError
        If the stiffness is not positive definite.

    References
    ----------
    Delafargue, Ulm, Int. J. Solids Struct. 41 (2004) 7351-7360, eq. 9, https://doi.org/10.1016/j.ijsolstr.2004.06.019

    Examples
    --------
    >>> import roughcontact as rc
    >>> zinc = TransverselyIsotropic(c11=165e9, c12=31e9, c13=50e9, c33=62e9, c44=39.6e9)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), "bearing steel")
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), zinc), grid=rc.Grid((32, 32), 100e-6))
    >>> print(f"{problem.plan.modulus / 1e9:.1f} GPa")
    53.6 GPa
    """

    c11: float = attrs.field(converter=_modulus, metadata={"unit": "Pa"})
    c12: float = attrs.field(converter=_coupling, metadata={"unit": "Pa"})
    c13: float = attrs.field(converter=_coupling, metadata={"unit": "Pa"})
    c33: float = attrs.field(converter=_modulus, metadata={"unit": "Pa"})
    c44: float = attrs.field(converter=_modulus, metadata={"unit": "Pa"})

    def __attrs_post_init__(self) -> None:
        _stiffness(self.stiffness)

    @property
    def stiffness(self) -> Matrix:
        """The stiffness as 6 rows of 6, Pa, for `Anisotropic`, where the axis does not lie along the normal."""
        axial = np.array(
            [[self.c11, self.c12, self.c13], [self.c12, self.c11, self.c13], [self.c13, self.c13, self.c33]]
        )
        return _blocks(axial, [self.c44, self.c44, 0.5 * (self.c11 - self.c12)])

    @property
    def compliance(self) -> float:
        """The inverse of E*, 1/Pa."""
        mean = math.sqrt(self.c11 * self.c33)
        soft = 1.0 / self.c44 + 2.0 / (mean + self.c13)
        return 0.5 * math.sqrt(self.c11 * soft / ((mean - self.c13) * (mean + self.c13)))

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf


def _blocks(axial: Array, shear: list[float]) -> Matrix:
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = axial
    matrix[range(3, 6), range(3, 6)] = shear
    return tuple(tuple(row) for row in matrix.tolist())
