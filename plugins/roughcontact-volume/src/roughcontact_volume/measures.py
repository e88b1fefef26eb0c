"""Numbers of a plastic zone: its size, what flowed in it, and what is left of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import roughcontact as rc
from roughcontact.typing import Array

from roughcontact_volume.box import find_operators, list_layers
from roughcontact_volume.kept_stress import keep_stress
from roughcontact_volume.radial_return import WEIGHTS, find_equivalent
from roughcontact_volume.substeps import ANSWERS, PlasticState
from roughcontact_volume.yielding import Yielding

# What is given with a load of a kind, and has no error.
_GIVEN = {"pressure": "force", "force": "force", "approach": "approach"}


def measure_flow(
    grid: rc.Grid,
    boundary: rc.Boundary,
    material: Yielding,
    state: PlasticState,
    step_errors: Array,
    kinds: Collection[str],
) -> Mapping[str, rc.Estimate | tuple[float, str]]:
    """Return the numbers of a state by name, each with its unit.

    These are the volume of the plastic zone, m3, its depth, m, the largest accumulated strain, the plastic work, J, the
    largest von Mises stress of the residual stress, Pa, and the energy that it has won, J, the depth of the imprint and
    the height of its pile-up, m; and the errors that are left by the substeps, but for what loads of these kinds give.
    """
    loaded = {_GIVEN[kind] for kind in kinds}
    thicknesses = list_layers(grid, state.layers)
    flowed = state.accumulated_strain > 0.0
    volumes = thicknesses * grid.cell_area
    in_layers = flowed.any(axis=(1, 2))
    work = float(np.einsum("z,zxy->", volumes, material.find_work(state.accumulated_strain)))
    given = material.residual
    stress = 0.0 if given is None else given.find_largest(float(thicknesses.sum()) if flowed.any() else 0.0)
    energy = 0.0
    if flowed.any():
        operators = find_operators(grid, boundary, state.layers, material)
        residual = operators.find_stress(state.plastic_strain)
        known = material.find_residual(thicknesses)[:, :, np.newaxis, np.newaxis]
        largest = max(float(find_equivalent(residual[:, z] + known[:, z]).max()) for z in range(state.layers))
        stress = max(stress, largest)
        product = np.einsum("c,czxy,czxy->z", WEIGHTS, residual, state.plastic_strain)
        energy = -0.5 * float(np.einsum("z,z->", volumes, product))
        # A residual stress r that was given adds -<r, e>.
        energy -= float(np.einsum("z,cz,czxy->", volumes, known[..., 0, 0], state.plastic_strain))
        keep_stress(operators, state.plastic_strain, residual)
    return {
        "plastic_volume": (float(np.einsum("z,z->", volumes, flowed.sum(axis=(1, 2)))), "m3"),
        "plastic_depth": (float(thicknesses[: np.flatnonzero(in_layers)[-1] + 1].sum()) if flowed.any() else 0.0, "m"),
        "plastic_strain": (float(state.accumulated_strain.max()), ""),
        "plastic_work": (work, "J"),
        "residual_stress": (stress, "Pa"),
        "residual_energy": (energy, "J"),
        "imprint_depth": (max(0.0, float(state.imprint.max())), "m"),
        "pile_up": (max(0.0, -float(state.imprint.min())), "m"),
        **{
            f"step_error_of_{name.replace(' ', '_')}": (error, unit)
            for (name, unit), error in zip(ANSWERS.items(), step_errors.tolist(), strict=True)
            if name not in loaded
        },
    }
