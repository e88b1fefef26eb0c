"""Claims about parts that read a solution: area estimators, flattening models and responses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any

import attrs
import numpy as np

from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.solution import Area, AreaEstimator, ContactSolution, Estimate, FlatteningModel, Response
from roughcontact.errors import InputError
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_invariant,
    claim_repeatable,
    pickled,
    read_fields,
    read_numbers,
    require,
    require_array,
    require_valid,
)
from roughcontact.testing.problems import (
    ELASTIC_CONTACTS,
    PLASTIC_CONTACTS,
    ChangedContact,
    adhesive_contact,
    full_contact,
    list_contacts,
    mirror_images,
    rough_contact,
    scale_units,
    shifted_copies,
    sphere_contact,
)

# Mean pressures over E* times the rms slope.
_LOADS = (0.002, 0.005, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
# Maximum difference of two areas, over the area, by rounding.
_MAX_AREA_DIFFERENCE = 1e-9
# Maximum relative difference of two numbers by rounding, of iterations in float32.
_MAX_NUMBER_DIFFERENCE = 1e-4


_all_contacts = list_contacts()
_plastic_contacts = list_contacts(*PLASTIC_CONTACTS)
_rough_contact = list_contacts("a rough surface")


@claim("area estimator", "valid areas and uncertainties", _all_contacts)
def _valid(estimator: AreaEstimator, solution: ContactSolution) -> None:
    area = estimator.estimate(solution)
    nominal = solution.grid.area
    require(isinstance(area, Area), f"it returns a {type(area).__name__}, not an Area")
    # An estimator need not give the perimeter.
    require_valid(attrs.evolve(area, perimeter=0.0))
    require(0.0 <= area.value <= nominal * (1 + _MAX_AREA_DIFFERENCE), f"{area.value} m2 of {nominal} m2")
    consistent = math.isclose(area.fraction, area.value / nominal, rel_tol=_MAX_AREA_DIFFERENCE)
    require(consistent, f"the fraction {area.fraction:g} is not the value over the nominal area")
    require(area.uncertainty < math.inf, f"an uncertainty of {area.uncertainty} m2")
    require(isinstance(area.estimator, str) and area.estimator, "`estimator` must be its name")


@claim("area estimator", "areas of patches", _all_contacts)
def _patches(estimator: AreaEstimator, solution: ContactSolution) -> None:
    area = estimator.estimate(solution)
    if area.patches is not None:
        require(area.patches.shape == (solution.patches.count,), "not one area for each contact patch")
        total = float(area.patches.sum())
        require(math.isclose(total, area.value, rel_tol=1e-6), f"the patches add up to {total:g} m2")


@claim("area estimator", "full contact")
def _full(estimator: AreaEstimator) -> None:
    area = estimator.estimate(full_contact())
    require(abs(area.fraction - 1.0) <= 1e-12, f"full contact is {100 * area.fraction:.6g} % of the domain")


@claim("area estimator", "no contact", _all_contacts)
def _empty(estimator: AreaEstimator, solution: ContactSolution) -> None:
    zero = np.zeros_like(solution.pressure)
    approach = -float(np.std(solution.initial_gap))
    area = estimator.estimate(attrs.evolve(solution, pressure=zero, displacement=zero, approach=approach))
    require(area.value == 0.0, f"separated, an area of {area.value:g} m2")
    require(area.uncertainty >= 0.0, f"separated, an uncertainty of {area.uncertainty} m2")


@claim("area estimator", "monotone in the load")
def _monotone(estimator: AreaEstimator) -> str:
    for boundary in (Boundary.PERIODIC, Boundary.FREE, Boundary.FREE_PERIODIC):
        found = [(load, estimator.estimate(rough_contact(load, boundary)).fraction) for load in _LOADS]
        for (light, less), (heavy, more) in itertools.pairwise(found):
            require(
                more >= less,
                f"boundary {boundary}: the area falls from {100 * less:.4g} to {100 * more:.4g} % as the load "
                f"rises from {light:g} to {heavy:g} of E* slope",
            )
    return f"from {100 * found[0][1]:.3g} to {100 * found[-1][1]:.3g} % over {len(_LOADS)} loads"


@claim("area estimator", "uncertainty covers Hertz")
def _hertz(estimator: AreaEstimator) -> str:
    rng = np.random.default_rng(2)
    covered = []
    worst = 0.0
    for cells in (2.5, 4.0, 6.5, 11.0):
        for x, y in rng.uniform(-0.5, 0.5, (4, 2)):
            solution = sphere_contact(cells, (float(x), float(y)))
            exact = math.pi * (cells * solution.grid.spacing[0]) ** 2
            area = estimator.estimate(solution)
            covered.append(abs(area.value - exact) <= 2 * area.uncertainty)
            worst = max(worst, abs(area.value / exact - 1.0))
    fraction = float(np.mean(covered))
    detail = f"{100 * fraction:.0f} % of the spheres lie within two standard deviations; errors reach {worst:.2g}"
    require(fraction >= 0.9, f"{detail}; at least 90 % are needed")
    return detail


def _estimate(estimator: AreaEstimator, solution: ContactSolution) -> tuple[float, float]:
    area = estimator.estimate(solution)
    return area.value, area.uncertainty


def _scale(_: object, solution: ContactSolution) -> Iterator[ChangedContact]:
    for length, stiffness in ((2.0**10, 1.0), (3e-4, 1.0), (1.0, 7e4)):
        yield ChangedContact(scale_units(solution, length, stiffness), partial(np.multiply, length**-2.0))


for _name, _changes in {
    "mirror images": lambda _, solution: mirror_images(solution),
    "shifted contacts": lambda _, solution: shifted_copies(solution, (1, 0), (0, 1), (17, 23)),
    "scales with units": _scale,
}.items():
    claim_invariant(
        "area estimator", _name, _all_contacts, _estimate, _changes, _MAX_AREA_DIFFERENCE, "the area differs"
    )
claim_repeatable("area estimator", _all_contacts, _estimate)


@claim("area estimator", "grids of few cells")
def _small_patches(estimator: AreaEstimator) -> None:
    for shape in ((2, 1), (1, 2), (1, 9), (3, 2)):
        for count in range(shape[0] * shape[1] + 1):
            contact = np.arange(shape[0] * shape[1]).reshape(shape) < count
            solution = attrs.evolve(
                full_contact(),
                grid=Grid(shape, (shape[0] * 1e-6, shape[1] * 1e-6)),
                pressure=np.where(contact, 1e6, 0.0),
                displacement=np.zeros(shape),
                initial_gap=np.where(contact, 0.0, 1e-8),
                approach=0.0,
                origin=None,
            )
            value = estimator.estimate(solution).value
            require(math.isfinite(value), f"{count} cells in contact of {shape} have {value} m2")


@claim("flattening model", "shapes and types", _all_contacts)
def _shapes(model: FlatteningModel, solution: ContactSolution) -> None:
    loss = model.height_loss(solution)
    require_array(loss, solution.grid.shape)
    require(np.isfinite(loss).all(), "values that are not finite")


@claim("flattening model", "no loss in elastic contact", list_contacts(*ELASTIC_CONTACTS))
def _no_loss(model: FlatteningModel, solution: ContactSolution) -> None:
    loss = float(np.abs(model.height_loss(solution)).max())
    require(loss == 0.0, f"a height loss of {loss:.2g} m in an elastic contact")


@claim("flattening model", "volume not increased", _plastic_contacts)
def _volume(model: FlatteningModel, solution: ContactSolution) -> None:
    loss = model.height_loss(solution)
    rise = -float(loss.mean()) / float(np.abs(loss).max(initial=1e-300))
    require(rise <= 1e-12, "the volume under the surfaces increases")
    deep = float(loss[solution.saturated].min())
    require(deep >= 0.0, f"saturated cells rise by {-deep:.2g} m")


claim_invariant(
    "flattening model",
    "mirrored and shifted contacts",
    _plastic_contacts,
    lambda model, solution: model.height_loss(solution),
    lambda _, solution: (*mirror_images(solution), *shifted_copies(solution, (7, 5))),
    1e-12,
    "the height loss of a mirrored or shifted contact differs",
)
claim_repeatable("flattening model", _plastic_contacts, lambda model, solution: [model.height_loss(solution)])


def _respond(response: Response[Any], solution: ContactSolution) -> Any:
    """Return the result; None where the response is refused in a sentence."""
    with suppress(InputError):
        return response.respond(solution)
    return None


def _read_value(response: Response[Any], solution: ContactSolution) -> list[float]:
    """Return the value of the result, if it is a finite number that is not zero."""
    result = _respond(response, solution)
    if not isinstance(result, Estimate) or not math.isfinite(result.value) or result.value == 0.0:
        raise DoesNotApply("its result is not an Estimate, or not finite, or zero")
    return [result.value]


@claim("response", "serves a rough contact")
def _serves(response: Response[Any]) -> None:
    contacts = [*(solution for _, solution in _all_contacts(response)), adhesive_contact()]
    found = (_respond(response, solution) for solution in contacts)
    require(any(result is not None for result in found), "it refuses every contact that is tried, or returns nothing")


@claim("response", "valid numbers and warnings", _all_contacts)
def _valid_response(response: Response[Any], solution: ContactSolution) -> None:
    result = _respond(response, solution)
    if result is not None and not isinstance(result, np.ndarray):
        require_valid(result)


claim_repeatable(
    "response",
    list_contacts("a rough surface", "a sphere"),
    lambda response, solution: read_numbers(_respond(response, solution)),
    copy=pickled,
)


def _move(response: Response[Any], solution: ContactSolution) -> tuple[ChangedContact, ...]:
    shifted = () if response.depends_on_place else shifted_copies(solution, (7, 5))
    # Its mirror image is another contact to what passes it in one direction.
    mirrored = () if hasattr(response, "direction") else mirror_images(solution)
    return *mirrored, *shifted


def _scale_to_digits(response: Response[Any], solution: ContactSolution) -> Iterator[ChangedContact]:
    """Give the contact in units of powers of two, and the answer to it times the power of two that suits it best."""
    if any(isinstance(value, float) for value in read_fields(response)):
        raise DoesNotApply("its fields may have units")
    one = _read_value(response, solution)[0]
    for length, stiffness in ((2.0**10, 1.0), (1.0, 2.0**-8)):
        yield ChangedContact(
            scale_units(solution, length, stiffness), lambda values: values / 2.0 ** np.round(np.log2(values / one))
        )


for _name, _moved, _detail in (
    ("mirrored and shifted contacts", _move, "the number differs"),
    ("scales with units", _scale_to_digits, "in units of powers of two the number has other digits"),
):
    claim_invariant("response", _name, _rough_contact, _read_value, _moved, _MAX_NUMBER_DIFFERENCE, _detail)
