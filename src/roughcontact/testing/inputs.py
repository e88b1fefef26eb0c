"""Claims about what a scene is made of: materials, surfaces and their readers, laws of attraction and of friction.

`roughcontact.testing` imports them for their effect, the registration; `check` runs them, nothing calls them by name.
Their texts are their interface: a stricter claim fails the plug-ins of others.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact._parts.files import SurfaceReader
from roughcontact._parts.grid import Grid
from roughcontact._parts.interactions import FrictionLaw, Interaction, shear_limit
from roughcontact._parts.materials import Elastic, Material, Rigid, combined_pressure_limit, contact_modulus
from roughcontact._parts.surfaces import ParaboloidSurface, Surface
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact.errors import InputError
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_input_unchanged,
    claim_repeatable,
    pickled,
    require,
    require_array,
    require_close,
    require_equal,
)

_COUNTERBODY = Elastic(1e9, 0.3)
# Gaps at which a law is tried, over its reach, and the step of central differences over the reach.
_GAPS = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 400)))
_STEP = 1e-6
# Relative error that central differences may have, over the maximum of what they are compared with.
_DIFFERENCE = 1e-4
# Cells of the ball that laws are tried on, and its radius over the reach of the law.
_BALL_CELLS = 24
_RADIUS = 40.0
# Pressures at which a law is tried, Pa.
_PRESSURES = np.concatenate(([0.0], np.geomspace(1.0, 1e11, 119)))


@claim("material", "compliance")
def _compliance(material: Material) -> str:
    found = number(material.compliance, "The compliance", "1/Pa", at_least=0.0)
    require(material.compliance == found, "a second reading gives another value")
    stiffer = contact_modulus(material, _COUNTERBODY) <= contact_modulus(Rigid(), _COUNTERBODY)
    require(stiffer, "a pair with it is stiffer than one with a rigid body")
    return f"{found:g} 1/Pa" if found else "rigid"


@claim("material", "pressure limit")
def _limit(material: Material) -> str:
    limit = material.pressure_limit
    require(np.ndim(limit) in (0, 2), f"an array of {np.ndim(limit)} dimensions is neither a number nor a map")
    softer = combined_pressure_limit(material, Rigid())
    require_equal(softer, combined_pressure_limit(Rigid(), material), "it depends on the order of the bodies")
    return "none" if np.isinf(softer).all() else f"{np.min(softer):g} to {np.max(softer):g} Pa"


@claim("material", "immutable")
def _immutable(material: Material) -> None:
    # A solution refers to its material: one that changes later would falsify it.
    kind: type = type(material)
    fields = [field.name for field in attrs.fields(kind)] if attrs.has(kind) else []
    for name in ("compliance", "pressure_limit", *fields):
        try:
            setattr(material, name, getattr(material, name))
        except (AttributeError, TypeError):
            continue
        require(False, f"{name} can be set")
    limit = material.pressure_limit
    require(not isinstance(limit, np.ndarray) or not limit.flags.writeable, "the map of limits can be written to")


@claim("material", "same values after pickling")
def _same_values(material: Material) -> None:
    copy = pickled(material)
    require_equal(copy.compliance, material.compliance, "its copy has another compliance")
    require_equal(copy.pressure_limit, material.pressure_limit, "its copy has another pressure limit")


@claim("material", "contact")
def _contact(material: Material) -> str:
    limit = material.pressure_limit
    shape = limit.shape if isinstance(limit, np.ndarray) else (16, 16)
    grid = Grid((shape[0], shape[1]), (shape[0] * 1e-6, shape[1] * 1e-6))
    body = Body(ParaboloidSurface(1e-4), material)
    other = Body(ParaboloidSurface(1e-3), _COUNTERBODY)
    problem = ContactProblem(body, other, grid=grid)
    solution = problem.solve(approach=0.1 * float(problem.initial_gap.max()))
    require((solution.pressure <= limit).all(), "a contact has pressures above the limit")
    require(problem.plan.modulus == contact_modulus(_COUNTERBODY, material), "it depends on the order of the bodies")
    return f"solved at {solution.mean_pressure:.3g} Pa, {np.count_nonzero(solution.saturated)} saturated cells"


def _heights(surface: Surface) -> tuple[Grid, Array]:
    """Return heights on a grid on which the surface is known, and the grid."""
    own = surface.own_grid
    others = Grid((24, 20), (24e-6, 20e-6)), Grid((24, 20), 1e-3), Grid((9, 8), 1.0)
    reasons = []
    for grid in others if own is None else (own,):
        try:
            return grid, surface.heights(grid)
        except InputError as error:
            reasons.append(str(error))
    raise AssertionError(f"it is known on none of the grids: {reasons[0]}")


@claim("surface", "shapes and types")
def _shapes(surface: Surface) -> str:
    grid, heights = _heights(surface)
    require_array(heights, grid.shape)
    require(np.isfinite(heights).all(), "heights that are not finite")
    mask = surface.non_measured_on(grid)
    boolean = mask is None or (mask.shape == grid.shape and mask.dtype == np.bool_)
    require(boolean, "the non-measured points are not booleans of the grid's shape")
    words = surface.provenance
    require(isinstance(words, tuple) and all(isinstance(text, str) for text in words), f"its provenance is {words!r}")
    return f"{np.ptp(heights):.3g} m from peak to valley on {grid}"


claim_repeatable("surface", None, lambda surface: [_heights(surface)[1]])


@claim("surface", "own grid")
def _own_grid(surface: Surface) -> str:
    own = surface.own_grid
    if own is None:
        raise DoesNotApply("it has no grid of its own")
    other = Grid((own.shape[0] + 1, own.shape[1]), own.size)
    try:
        surface.heights(other)
    except InputError:
        return str(own)
    raise AssertionError(f"its own grid is {own}, but it has heights on {other}")


@claim("surface", "parts")
def _parts(surface: Surface) -> str:
    if not surface.parts:
        raise DoesNotApply("it is not made of other surfaces")
    grid, heights = _heights(surface)
    copy = surface.with_parts(surface.parts)
    require_equal(copy.heights(grid), heights, "made of the same parts, it has other heights")
    return f"made of {len(surface.parts)}"


def _require_similar(change: Callable[[], Surface], grid: Grid, heights: Array) -> None:
    """Require that the changed surface, unless it is refused, has heights within 1.5 times the range of others."""
    try:
        found = change()
    except InputError as error:
        raise DoesNotApply(str(error)) from error
    others = found.heights(grid)
    require(others.shape == grid.shape and np.isfinite(others).all(), f"no finite heights of shape {grid.shape}")
    margin = 0.5 * float(np.ptp(heights))
    inside = others.min() >= heights.min() - margin and others.max() <= heights.max() + margin
    require(inside, f"heights from {others.min():g} to {others.max():g} m, out of range")


@claim("surface", "resampled")
def _resampled(surface: Surface) -> None:
    grid, heights = _heights(surface)
    require_equal(surface.resample_to(grid).heights(grid), heights, "resampled to its own grid it has other heights")
    finer = Grid((2 * grid.shape[0], 2 * grid.shape[1]), grid.size)
    _require_similar(lambda: surface.resample_to(finer), finer, heights)


@claim("surface", "shifted by half a cell")
def _shifted(surface: Surface) -> None:
    grid, heights = _heights(surface)
    _require_similar(lambda: surface.shift_half_cell(grid, periodic=True), grid, heights)


@claim("surface", "reseeded")
def _reseeded(surface: Surface) -> None:
    grid, heights = _heights(surface)
    other = surface.reseed(1)
    if other is None:
        raise DoesNotApply("it has no random seed")
    require(not np.array_equal(other.heights(grid), heights), "another seed gives the same heights")
    back = other.reseed(-1)
    require_equal(back and back.heights(grid), heights, "the same seed gives other heights")


@claim("surface reader", "file endings")
def _endings(reader: SurfaceReader) -> str:
    suffixes = reader.suffixes
    require(isinstance(suffixes, frozenset), f"`suffixes` is a {type(suffixes).__name__}, not a frozenset")
    wrong = [suffix for suffix in suffixes if not suffix.startswith(".") or suffix != suffix.lower()]
    require(not wrong, f"the endings {wrong} are not in lower case with a dot")
    return " ".join(sorted(suffixes)) or "none: it is chosen by name, or last"


@claim("surface reader", "damaged files refused")
def _damaged(reader: SurfaceReader) -> None:
    noise = np.random.default_rng(0).bytes(999)
    with tempfile.TemporaryDirectory() as folder:
        for suffix in sorted(reader.suffixes) or [".unknown"]:
            for number_of_file, content in enumerate((b"", b"\0" * 64, noise)):
                path = Path(folder) / f"damaged{number_of_file}{suffix}"
                path.write_bytes(content)
                try:
                    found = reader.read(path)
                # Any error is allowed: `read_surface` says which file it was.
                except Exception:
                    continue
                require(False, f"{len(content)} bytes of noise with the ending {suffix} were read as {found!r:.60}")


def _resolved(law: Interaction) -> Interaction:
    """Return the law itself, or that of a grid of micrometres on a soft solid."""
    return law.resolve((1e-6, 1e-6), 1e7)


def _shaped_gaps(law: Interaction) -> Array:
    """Return gaps to try a law at, shape (n, 1, 1), or (n, nx, ny) where its parameters are arrays."""
    shape = np.broadcast_shapes(np.shape(law.work), np.shape(law.strength)) or (1, 1)
    return np.broadcast_to((_GAPS * law.reach)[:, np.newaxis, np.newaxis], (_GAPS.size, *shape)).copy()


@claim("interaction", "attracts")
def _attracts(law: Interaction) -> str:
    law = _resolved(law)
    tensions = np.array([law.tension(gap) for gap in _shaped_gaps(law)])
    require(np.isfinite(tensions).all(), "a tension is not finite")
    require(tensions.min() >= 0.0, "a tension is negative: the surfaces repel each other")
    require(np.min(law.work) > 0.0, "the work of adhesion is not above zero")
    return f"work {np.max(law.work):.3g} J/m2, strength {np.max(law.strength):.3g} Pa, reach {law.reach:.3g} m"


@claim("interaction", "tension is the derivative of the energy")
def _derivative(law: Interaction) -> str:
    law = _resolved(law)
    return f"to {_compare(law, law.energy, law.tension):.0e}"


@claim("interaction", "slope is the derivative of the tension")
def _slope(law: Interaction) -> str:
    law = _resolved(law)
    return f"to {_compare(law, law.tension, law.slope):.0e}"


def _compare(law: Interaction, value: object, derivative: object) -> float:
    step = _STEP * law.reach
    gaps = _shaped_gaps(law) + step
    found = np.array([(value(gap + step) - value(gap - step)) / (2.0 * step) for gap in gaps])  # type: ignore[operator]
    expected = np.array([derivative(gap) for gap in gaps])  # type: ignore[operator]
    return require_close(found, expected, _DIFFERENCE, "central differences are another derivative")


@claim("interaction", "ends at its reach")
def _ends(law: Interaction) -> None:
    law = _resolved(law)
    beyond = np.abs(law.energy(1.001 * _shaped_gaps(law)[-1]))
    require(bool((beyond <= 1.01e-6 * np.max(law.work)).all()), "beyond its reach more than 1e-6 of the work is left")


@claim("interaction", "shape")
def _shape(law: Interaction) -> None:
    law = _resolved(law)
    gaps = _shaped_gaps(law)[3]
    for precision in (np.float32, np.float64):
        given = gaps.astype(precision)
        kept = given.copy()
        for function in (law.tension, law.slope, law.energy):
            values = np.asarray(function(given))
            require(values.shape == given.shape, f"{values.shape} for gaps of shape {given.shape}")
        require_equal(given, kept, "it writes into the gap")


@claim("interaction", "contact")
def _contact_of_ball(law: Interaction) -> str:
    resolved = _resolved(law)
    if np.ndim(resolved.work) or np.ndim(resolved.strength):
        raise DoesNotApply("its parameters are arrays, for a grid of their own")
    reach = float(np.max(resolved.work) / np.max(resolved.strength))
    spacing = 2.0 * reach
    grid = Grid((_BALL_CELLS, _BALL_CELLS), _BALL_CELLS * spacing)
    # The modulus at which the cohesive length has three cells.
    modulus = 3.0 * resolved.steepest * spacing
    body = Body(ParaboloidSurface(_RADIUS * spacing), Elastic(modulus, 0.0))
    problem = ContactProblem(body, grid=grid, adhesion=resolved)
    free = ContactProblem(body, grid=grid)
    force = resolved.work * np.pi * _RADIUS * spacing
    pressed = problem.solve(force=float(force))
    without = free.solve(force=float(force))
    require(pressed.contact.sum() >= without.contact.sum(), "with it the contact is smaller than without")
    closer = pressed.approach > 1.001 * without.approach
    require(closer, "with it the bodies do not approach more than without")
    return f"{int(pressed.contact.sum())} cells in contact, {int(without.contact.sum())} without it"


def _fields(law: FrictionLaw) -> list[Array]:
    """Return uniform pressures to try a law at, of the shape of its arrays."""
    maps = [np.shape(getattr(law, field.name)) for field in getattr(type(law), "__attrs_attrs__", ())]
    shape = next((one for one in maps if len(one) == 2), (12, 10))
    return [np.full(shape, pressure) for pressure in _PRESSURES]


@claim("friction law", "limits")
def _limits(law: FrictionLaw) -> str:
    # `shear_limit` requires the shape, finite values, at least zero, and none without pressure.
    limits = [shear_limit(law, field) for field in _fields(law)]
    return f"from {min(limit.max() for limit in limits):.3g} to {max(limit.max() for limit in limits):.3g} Pa"


@claim("friction law", "not falling with the pressure")
def _monotone(law: FrictionLaw) -> None:
    limits = np.array([law.limit(field) for field in _fields(law)])
    require((np.diff(limits, axis=0) >= 0.0).all(), "the limit falls as the pressure rises")


@claim("friction law", "local")
def _local(law: FrictionLaw) -> None:
    fields = _fields(law)
    one = fields[60].copy()
    before = law.limit(one.copy())
    one[0, 0] *= 2.0
    after = law.limit(one)
    after[0, 0] = before[0, 0]
    require_equal(after, before, "the pressure of one cell changes the limit of another")


claim_input_unchanged(
    "friction law",
    lambda law: [("a pressure", _fields(law)[60])],
    lambda law, field: ({"pressure": field}, lambda: law.limit(field)),
)
claim_repeatable(
    "friction law", None, lambda law: [law.limit(_fields(law)[60])], lambda law: law.limit(_fields(law)[3])
)
