"""What the settings of the page describe: a surface, a problem, loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from roughcontact import (
    Boundary,
    ContactProblem,
    CoupledProcess,
    Elastic,
    ElasticPerfectlyPlastic,
    Grid,
    HeightMap,
    ParaboloidSurface,
    SphereSurface,
    Surface,
    Viscoelastic,
    examples,
    interactions,
    match,
    read_surface,
    surfaces,
)
from roughcontact.errors import InputError, MissingPackage, RoughContactError
from roughcontact.faces import build_layer, build_problem, list_fields
from roughcontact.solving import require_memory_of_solve
from roughcontact.typing import Load, Pair, RawMap, read_raw

from roughcontact_app.material_fields import read_material
from roughcontact_app.materials import MATERIAL_FORMS, name_material
from roughcontact_app.settings import (
    DEFAULTS,
    PREFIXES,
    Settings,
    WrongSetting,
    chosen_laws,
    cycle_values,
    fretting_values,
    list_values,
    load_values,
    plain,
    quantity,
    reading,
    whole,
)

EXAMPLES: dict[str, Callable[[], HeightMap]] = {
    one.__name__: one for one in (examples.ground_ring, examples.ball, examples.lapped_plate, examples.honed_liner)
}
MEASURED = ("file", "example")
# Points of a map that the page takes: it is read, drawn and planned while somebody waits. 8192 x 8192.
_MOST_POINTS = 2**26
# Settings of each of two files.
_OF_FILES = ("file_name", "size_x", "size_y", "height_unit", "rows", "non_measured")
_FORMS: dict[str, str | int] = {"plane": "plane", "quadratic": 2, "sphere": "sphere"}
# Kinds of quantities by their units, and what sentences call fields whose names do not say it.
_KINDS = {"m": "length", "Pa": "modulus", "J/m2": "work"}
_LABELS = {
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "hurst": "The Hurst exponent",
    "shortest": "The shortest wavelength",
    "longest": "The longest wavelength",
    "radius": "The radius of the sphere",
    "work": "The work of adhesion",
    "range": "The range of the adhesion",
}
# Settings of units that several fields share, and fields that are omitted where they are empty.
_UNIT_SETTINGS = {"shortest": "wave_unit", "longest": "wave_unit"}
_MAY_BE_EMPTY = ("hardness", "yield_stress")
# Units of the fields of a layer, whose class is another package's.
_OF_LAYER = {"young": "Pa", "poisson": "", "thickness": "m", "yield_stress": "Pa"}
# Degrees.
_FULL_TURN = 360.0


@attrs.frozen
class Upload:
    """A file that the page has sent: where it lies under a name of the server's, and the name that the user knows."""

    path: Path = attrs.field(converter=Path)
    name: str


@attrs.frozen(eq=False)
class ShownSurface:
    """A surface as it is shown, without ball or cylinder.

    Attributes
    ----------
    surface
        Its heights on the grid of the scene.
    source
        The map as it was read and freed from its form; the surface itself if there is no map.
    filled
        Number of its non-measured points that were filled.
    """

    surface: Surface
    source: Surface
    filled: int = 0


@attrs.frozen(eq=False)
class Scene:
    """The surfaces on their grid.

    Attributes
    ----------
    surface
        The heights of the body, ball or cylinder included.
    grid
        The cells.
    body
        The surface of the body as it is shown.
    counterbody
        The map of the counterbody; None of a flat.
    """

    surface: Surface
    grid: Grid
    body: ShownSurface
    counterbody: ShownSurface | None = None


def make_scene(settings: Settings, upload: Upload | None, counterbody_upload: Upload | None = None) -> Scene:
    """Return the surfaces that the settings describe, or raise `InputError`."""
    kind = settings["surface"]
    counterbody = None
    if kind in MEASURED:
        read, filled = _read(settings, upload) if kind == "file" else (_example(settings), 0)
        grid = read.grid
        source = _treat(settings, read)
        body = ShownSurface(source, source, filled)
        # The page asks for no second map beside other surfaces.
        if settings["counterbody_surface"] == "file":
            other, filled = _read(settings, counterbody_upload, "counterbody_")
            other = _treat(settings, other, "counterbody_")
            placement = _read_placement(settings)
            with reading("offset_x"):
                pair = match(source, other, **placement)
            grid = pair.grid
            body = attrs.evolve(body, surface=pair.body)
            counterbody = ShownSurface(pair.counterbody, other, filled)
    else:
        cells = whole(settings, "cells", "The number of cells along a side")
        grid = Grid((cells, cells), quantity(settings, "side", "The side of the domain", "length"))
        made = _make_synthetic(settings)
        body = ShownSurface(made, made)
    # Before there are heights.
    require_memory_of_solve(grid, Boundary(settings["boundary"]))
    return Scene(_add_ball(settings, body.surface), grid, body, counterbody)


def _treat(settings: Settings, surface: HeightMap, prefix: str = "") -> HeightMap:
    """Return a map from which the tip of a stylus is taken away, and then its form, where that is chosen."""
    tip = f"{prefix}tip_radius"
    if settings[tip]:
        radius = quantity(settings, tip, "The radius of the tip", "length")
        with reading(tip):
            surface = surface.restored(radius)
    form = settings[f"{prefix}form"]
    return surface if form == "none" else surface.detrend(_FORMS[form])


def _read_placement(settings: Settings) -> dict[str, Any]:
    """Return how the second map lies on the first, as `roughcontact.match` takes it."""
    x, y = (
        quantity(settings, name, f"The shift along {name[-1]}", "length", "offset_unit", signed=True)
        for name in ("offset_x", "offset_y")
    )
    angle = plain(settings, "rotation", "The rotation")
    if not abs(angle) <= _FULL_TURN:
        with reading("rotation"):
            raise InputError.about("The rotation", angle, f"between -{_FULL_TURN:g} and {_FULL_TURN:g} degrees")
    return {
        "offset": (x, y),
        "rotation": math.radians(angle),
        "mirrored": settings["mirrored"] == "yes",
        "interpolation": settings["interpolation"],
    }


def _add_ball(settings: Settings, surface: Surface) -> Surface:
    """Return a surface with the ball or cylinder that is added, if any."""
    # The page asks for no ball beside a sphere.
    if settings["surface"] == "sphere" or not settings["ball"]:
        return surface
    radius = quantity(settings, "ball", "The radius of the ball or cylinder", "length")
    added: Surface = SphereSurface(radius)
    if settings["added"] != "ball":
        added = ParaboloidSurface((radius, math.inf) if settings["added"] == "cylinder-y" else (math.inf, radius))
    return surface + added


def make_problem(settings: Settings, scene: Scene) -> ContactProblem:
    """Return the problem that the settings describe, or raise `InputError`."""
    deforms = settings["counterbody"] != "rigid"
    material = _describe_material(settings, "", "the body")
    return build_problem(
        {
            "body": {"surface": scene.surface, "material": material, **_describe_layers(settings, "", "the body")},
            "counterbody": {
                "surface": "flat" if scene.counterbody is None else scene.counterbody.surface,
                "material": _describe_material(settings, "counterbody_", "the counterbody") if deforms else "rigid",
                **_describe_layers(settings, "counterbody_", "the counterbody"),
            },
            "grid": scene.grid,
            "boundary": settings["boundary"],
            "adhesion": _describe_interaction(settings),
            "laws": chosen_laws(settings),
        }
    )


def _describe_layers(settings: Settings, prefix: str, whose: str) -> dict[str, Any]:
    """Return the layers of a body, from the surface downwards; empty without any."""
    layers = []
    for number in range(1, int(settings[f"{prefix}layers"]) + 1):
        own = f"{prefix}layer{number}_"
        fields = _read_fields(settings, _OF_LAYER, own, f" of layer {number} of {whose}")
        try:
            with reading(f"{own}poisson"):
                layers.append(build_layer(fields, f"Layer {number} of {whose}"))
        except MissingPackage as error:
            raise WrongSetting(str(error), f"{prefix}layers") from error
    return {"layers": layers} if layers else {}


def _describe_interaction(settings: Settings) -> dict[str, Any] | None:
    name = settings["adhesion"]
    return None if name == "none" else {"type": name, **_read_fields(settings, _units_of(interactions[name]))}


def _units_of(cls: type) -> dict[str, str | None]:
    """Return the unit of each field of a part; empty for a plain number, None for a whole one."""
    return {name: field.unit for name, field in list_fields(cls).items()}


def _read_fields(settings: Settings, units: Mapping[str, str | None], prefix: str = "", of: str = "") -> dict[str, Any]:
    """Return those fields of a part that the page has, from settings that begin with a prefix.

    `units` are those of all its fields; `of` ends what a sentence calls one.
    """
    found: dict[str, Any] = {}
    for name, unit in units.items():
        setting = f"{prefix}{name}"
        label = f"{_LABELS.get(name, 'The ' + name.replace('_', ' '))}{of}"
        if setting not in DEFAULTS or (name in _MAY_BE_EMPTY and not settings[setting]):
            continue
        if unit is None:
            found[name] = whole(settings, setting, label)
        elif not unit:
            found[name] = plain(settings, setting, label)
        else:
            own = _UNIT_SETTINGS.get(name)
            found[name] = quantity(settings, setting, label, _KINDS[unit], own, zero=name == "amplitude")
    return found


def require_solvable(settings: Settings, problem: ContactProblem) -> None:
    """Raise `InputError` where what the material of a body does with its contact is not solved with the rest."""
    for prefix, name in zip(PREFIXES, ("body", "counterbody"), strict=True):
        material = getattr(problem, name).material
        laws = material.bring_laws(name)
        is_known = not laws and hasattr(material, "poisson")
        if settings["load"] == "fretting" and settings[f"{prefix}material"] in MATERIAL_FORMS and not is_known:
            words = name_material(settings[f"{prefix}material"])
            sentence = f"Friction with the material '{words}' is not known: choose another material, or another load."
            raise WrongSetting(sentence, f"{prefix}material")
        for law in laws:
            if isinstance(law, CoupledProcess):
                with reading(f"{prefix}material"):
                    law.start(problem)


def make_loads(settings: Settings, problem: ContactProblem) -> tuple[Load, ...]:
    """Return the loads that the bodies can carry, or raise `InputError`.

    Of a cycle they are those of a branch, of a fretting cycle the normal load.
    """
    if settings["load"] == "fretting":
        return (problem.require_load(force=fretting_values(settings)[0]),)
    if settings["load"] == "cycle":
        return problem.require_cycle(approach=cycle_values(settings))
    values = load_values(settings)
    with reading("loads"):
        return tuple(problem.require_load(**{settings["load"]: value}) for value in values)


def inspect_file(upload: Upload) -> dict[str, object]:
    """Return the facts that a file of heights states, for the page to ask for the others."""
    return _facts(_read_raw(upload))


def _facts(raw: RawMap) -> dict[str, object]:
    values = raw.heights if raw.heights.dtype.kind == "f" else np.zeros(1)
    return {
        "shape": list(raw.heights.shape),
        "size": None if raw.size is None else list(raw.size),
        "metric": raw.metric,
        "needs_rows": raw.needs_rows,
        "non_measured": int(np.count_nonzero(~np.isfinite(values))),
    }


def _read_raw(upload: Upload) -> RawMap:
    try:
        raw = read_raw(upload.path)
    except (InputError, MissingPackage) as error:
        raise _renamed(error, upload) from error
    if raw.heights.size > _MOST_POINTS:
        shape = " x ".join(map(str, raw.heights.shape))
        raise InputError(
            f"The file {upload.name} has {shape} points, but the page takes {_MOST_POINTS:.3g} at most: cut the map, "
            "or solve it in a script."
        )
    return raw


def _read(settings: Settings, upload: Upload | None, prefix: str = "") -> tuple[HeightMap, int]:
    """Return the map in a file, and how many of its points were filled; its settings begin with a prefix."""
    own = {name: settings[f"{prefix}{name}"] for name in _OF_FILES}
    if upload is None:
        named = own["file_name"] or f"the height map{' of the counterbody' if prefix else ''}"
        raise InputError(f"Choose a file, or drop one on the page: {named} is not here.")
    facts = _facts(_read_raw(upload))
    if facts["size"] is None and not (own["size_x"] and own["size_y"]):
        cells = " x ".join(map(str, facts["shape"]))  # type: ignore[call-overload]
        raise WrongSetting(
            f"The file {upload.name} holds {cells} heights but not the size of its domain: "
            "fill in both sides, x and y.",
            f"{prefix}size_x",
        )
    if not facts["metric"] and not own["height_unit"]:
        sentence = f"The file {upload.name} does not state the unit of its heights: choose it."
        raise WrongSetting(sentence, f"{prefix}height_unit")
    if facts["non_measured"] and own["non_measured"] == "refuse":
        raise WrongSetting(
            f"In the file {upload.name} {facts['non_measured']} points were not measured: choose whether to fill "
            "them from their neighbours or to keep them as points that never touch.",
            f"{prefix}non_measured",
        )
    try:
        surface = read_surface(
            upload.path,
            size=None if facts["size"] is not None else _size(settings, prefix),
            unit=None if facts["metric"] else float(f"1{_exponent(own['height_unit'])}"),
            non_measured=own["non_measured"],
            **({"rows": own["rows"]} if facts["needs_rows"] else {}),
        )
    except InputError as error:
        raise _renamed(error, upload) from error
    history = tuple(step.replace(upload.path.name, upload.name) for step in surface.history)
    filled = facts["non_measured"] if own["non_measured"] == "fill" else 0
    return attrs.evolve(surface, history=history), int(filled)  # type: ignore[call-overload]


def _size(settings: Settings, prefix: str) -> Pair:
    x, y = (
        quantity(settings, f"{prefix}{name}", f"The side of the map along {name[-1]}", "length", f"{prefix}size_unit")
        for name in ("size_x", "size_y")
    )
    return x, y


def _exponent(unit: str) -> str:
    known = {"m": "e0", "mm": "e-3", "um": "e-6", "nm": "e-9"}
    if unit not in known:
        raise InputError.about("The unit of the heights", unit, f"one of {', '.join(known)}")
    return known[unit]


def _renamed(error: RoughContactError, upload: Upload) -> RoughContactError:
    """Return the error with the name of the file that the user knows."""
    return type(error)(
        (error.marked if isinstance(error, InputError) else str(error))
        .replace(str(upload.path), upload.name)
        .replace(upload.path.name, upload.name)
    )


def _example(settings: Settings) -> HeightMap:
    if settings["example"] not in EXAMPLES:
        raise InputError.unknown("example", settings["example"], EXAMPLES)
    return EXAMPLES[settings["example"]]()


def _make_synthetic(settings: Settings) -> Surface:
    fields = _read_fields(settings, _units_of(surfaces[settings["surface"]]))
    if fields.get("shortest", 0.0) > fields.get("longest", math.inf):
        waves = (f"{settings[name]} {settings['wave_unit'].replace('u', 'µ')}" for name in ("shortest", "longest"))
        sentence = "The shortest wavelength, {}, must not be above the longest one, {}.".format(*waves)
        raise WrongSetting(sentence, "shortest")
    made: Surface = surfaces.create(settings["surface"], **fields)
    return made


def _describe_material(settings: Settings, prefix: str, whose: str) -> dict[str, Any]:
    kind = settings[f"{prefix}material"]
    if kind != "elastic":
        for name in PREFIXES:
            if settings[f"{name}layers"] != "0":
                sentence = f"Layers beside a {name_material(kind)} body are not known: choose no layers, or another "
                raise WrongSetting(f"{sentence}material.", f"{name}layers")
    if kind in MATERIAL_FORMS:
        return read_material(settings, prefix, whose)
    if kind == "viscoelastic":
        series: dict[str, Any] = {
            "moduli": list_values(settings, f"{prefix}moduli", f"moduli of {whose}", "modulus"),
            "times": list_values(settings, f"{prefix}relaxation", f"relaxation times of {whose}", "time"),
            "poisson": plain(settings, f"{prefix}poisson", f"Poisson's ratio of {whose}"),
        }
        with reading(f"{prefix}relaxation"):
            Viscoelastic(**series)
        return {"type": "viscoelastic", **series}
    material = _read_fields(settings, _units_of(ElasticPerfectlyPlastic), prefix, f" of {whose}")
    with reading(f"{prefix}poisson"):
        Elastic(material["young"], material["poisson"])
    return material
