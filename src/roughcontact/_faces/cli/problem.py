"""The contact problems and loads that the options of a command describe, or a study file."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import attrs

import roughcontact as rc
from roughcontact._base.registry import Registry, list_fields
from roughcontact._faces.cli.options import add_problem, refuse
from roughcontact._parts.files import list_reader_options, read_raw
from roughcontact._parts.files.reading import options_of
from roughcontact._parts.grid import Boundary, Load
from roughcontact._parts.materials import TYPICAL
from roughcontact._solve.problem import require_memory_of_solve
from roughcontact._work.studies import LAYERED, build_layer, build_part, build_problem, find_layer_class

# Options of which one describes the material of a body.
MATERIALS = ("young", "material", "viscoelastic")
# Options by which passes what a law depends on.
_RATES = {"time": ("time",), "sliding": ("sliding", "shift"), "slip": ("tangential",)}


def loads_of(options: argparse.Namespace) -> tuple[Load, ...]:
    """Return the loads that the options state; none if the load is asked for."""
    if getattr(options, "cycle", None) is not None:
        return tuple(Load("approach", value) for value in options.cycle)
    if getattr(options, "solve_for", None) is not None:
        return ()
    several = getattr(options, "loads", None)
    make = Load.of if options.adhesion is None else Load.signed
    return several or (make(pressure=options.pressure, force=options.force, approach=options.approach),)


def problem_of(options: argparse.Namespace) -> rc.ContactProblem:
    """Return the problem that the options describe."""
    surface, counterbody, matching = _surfaces(options)
    if getattr(options, "mirror_borders", False):
        if matching is not None:
            raise rc.InputError("--mirror-borders is for maps with the same cells: omit --match.")
        surface, counterbody = (
            one.mirror_borders() if isinstance(one, rc.HeightMap) else one for one in (surface, counterbody)
        )
    if options.ball is not None:
        surface = surface + rc.SphereSurface(options.ball)
    if options.roller is not None:
        radii = options.roller, math.inf
        along_x = options.boundary == str(Boundary.PERIODIC_FREE)
        surface = surface + rc.ParaboloidSurface(radii[::-1] if along_x else radii)
    table = {
        "body": {"surface": surface, "material": _describe_material(options), **_describe_layers(options)},
        "counterbody": {
            "surface": counterbody,
            "material": _describe_counterbody_material(options),
            **_describe_layers(options, "counterbody_"),
        },
        "adhesion": None if options.adhesion is None else _adhesion(options),
        "laws": _read_laws(options),
        **_describe_kernel(options),
        **{name: getattr(options, name) for name in ("boundary", "solver", "threads")},
    }
    return build_problem(table if matching is None else {**table, "match": matching})


def _read_laws(options: argparse.Namespace) -> list[rc.Law]:
    """Return the laws of the options; `InputError` for one of which nothing passes that it depends on."""
    laws: list[rc.Law] = [make_part(rc.laws, "--law", name, texts) for name, *texts in options.law or ()]
    for law, (name, *_) in zip(laws, options.law or (), strict=True):
        # A law that does not say what it depends on may change with any load.
        rates = () if law.rates == rc.Law.rates else law.rates
        needed = [f"--{one}" for rate in rates for one in _RATES.get(rate, ())]
        # What else does not fit friction, the problem itself refuses.
        counts = "slip" in rates or getattr(options, "friction", None) is None
        if needed and counts and all(getattr(options, one[2:], None) is None for one in needed):
            raise rc.InputError(
                f"--law {name} changes nothing without {' or '.join(needed)}: give that too, or omit the law."
            )
    if getattr(options, "speed", None) is not None:
        laws.append(rc.SteadySliding(options.speed, math.degrees(options.slide)))
    return laws


def set_tolerance(options: argparse.Namespace, problem: rc.ContactProblem) -> rc.ContactProblem:
    """Return a problem whose solver has the tolerance that the options state, if they do."""
    if options.tolerance is None:
        return problem
    return attrs.evolve(problem, solver=problem.plan.solver.with_tolerance(options.tolerance))


def _adhesion(options: argparse.Namespace) -> rc.Interaction:
    name, *texts = options.adhesion
    law: rc.Interaction = make_part(rc.interactions, "--adhesion", name, texts)
    return law


def make_part(registry: Registry[Any], option: str, name: str, texts: Sequence[str]) -> Any:
    """Return the part with a registered name, its fields from texts such as ``work=50mJ/m2`` or ``depths=1um,2um``."""
    what = option if option == f"--{name}" else f"{option} {name}"
    return build_part(registry, name, _read_fields(texts, what, registry[name]), what)


def _read_fields(texts: Sequence[str], what: str, cls: type[Any]) -> dict[str, Any]:
    """Return the texts of the fields of a class by name; its first words do, as ``yield`` of ``yield_stress``.

    A point leads to the fields of a part that is a field, as ``hardening.type``.
    """
    known = list_fields(cls)
    fields: dict[str, Any] = {}
    # A comma separates fields too, but not the values of one.
    for text in (part for several in texts for part in re.split(r",(?=[\w.]+=)", several)):
        field, equals, value = text.partition("=")
        if not equals:
            raise rc.InputError.about(f"A field of {what}", text, "FIELD=VALUE")
        field, dot, inner = field.partition(".")
        meant = [name for name in known if field not in known and name.startswith(f"{field}_")]
        name = meant[0] if len(meant) == 1 else field
        table, entry = (fields.setdefault(name, {}), inner) if dot else (fields, name)
        if not isinstance(table, dict) or entry in table:
            raise rc.InputError(f"{what} has {name}{dot}{inner} twice: give it once.")
        is_list = name in known and Ellipsis in get_args(known[name].kind)
        table[entry] = value.split(",") if is_list or "," in value else value
    return fields


def _describe_layers(options: argparse.Namespace, prefix: str = "") -> dict[str, Any]:
    """Return the layers that options of this prefix describe, from the surface downwards; empty without any."""
    given: list[list[str]] | None = getattr(options, f"{prefix}layer")
    if given is None:
        return {}
    option = f"--{prefix.replace('_', '-')}layer"
    cls = find_layer_class()
    names = [f"{option}{'' if len(given) == 1 else f' {number}'}" for number in range(1, len(given) + 1)]
    return {
        "layers": [build_layer(_read_fields(texts, what, cls), what) for texts, what in zip(given, names, strict=True)]
    }


def _describe_kernel(options: argparse.Namespace) -> dict[str, Any]:
    """Return the kernel that the options name, and its fields; empty for the default one."""
    if options.kernel is None:
        return {}
    name, *texts = options.kernel
    if name == LAYERED and not texts:
        if options.layer is None and options.counterbody_layer is None:
            raise rc.InputError("--kernel layered needs layers: give --layer or --counterbody-layer.")
        return {}
    if not texts:
        return {"kernel": name}
    return {"kernel": {"type": name, **_read_fields(texts, f"--kernel {name}", rc.kernels[name])}}


def _surfaces(options: argparse.Namespace) -> tuple[rc.Surface, rc.Surface, dict[str, Any] | None]:
    """Return both surfaces, and how they are matched."""
    if options.counterbody is None:
        names = ("match", *(f"counterbody_{name}" for name in ("size", "unit", "tip_radius", "detrend")))
        refuse(options, names, "is for the second of two height maps: give its file too, or omit the option.")
    if options.match is None:
        if options.mirror and getattr(options, "mirror_borders", None) is not None and options.counterbody is None:
            raise rc.InputError("--mirror turns a second map over; --mirror-borders repeats maps that do not repeat.")
        names = ("offset", "rotation", "domain", "mirror")
        refuse(options, names, "is for two maps that are interpolated: give both, and --match bilinear.")
    body = read_map(options)
    if options.counterbody is None:
        return _resample(body, options), rc.FlatSurface(), None
    form = options.detrend if options.counterbody_detrend is None else options.counterbody_detrend
    tip = options.tip_radius if options.counterbody_tip_radius is None else options.counterbody_tip_radius
    counterbody = _read(options.counterbody, options, *_counterbody_size_and_unit(options), tip, form)
    if options.match is None:
        body = _resample(body, options)
        counterbody = _resample(counterbody, options)
        if not body.grid.matches(counterbody.grid):
            raise rc.InputError(
                f"The height maps are given on {body.grid} and {counterbody.grid}: give --match bilinear, which "
                "interpolates both on a common grid, or --resample NX NY where only their cells differ."
            )
        return body, counterbody, None
    matching = {
        "offset": options.offset or (0.0, 0.0),
        "rotation": options.rotation or 0.0,
        "mirrored": options.mirror,
        "interpolation": options.match,
        "shape": options.resample,
        "size": _sides(options.domain),
    }
    return body, counterbody, matching


def _counterbody_size_and_unit(options: argparse.Namespace) -> tuple[list[float] | None, float | None]:
    """Return size and unit of the second map: its own, or those of the first if its file does not state them."""
    size = options.counterbody_size
    unit = options.counterbody_unit
    if size is None or unit is None:
        raw = read_raw(Path(options.counterbody), **_options_of_reader(options, options.counterbody))
        size = options.size if size is None and raw.size is None else size
        unit = options.unit if unit is None and not raw.metric else unit
    return size, unit


def read_map(options: argparse.Namespace) -> rc.HeightMap:
    """Return the height map of the body, treated as the options say."""
    return _read(options.surface, options, options.size, options.unit, options.tip_radius, options.detrend)


def _read(
    path: str,
    options: argparse.Namespace,
    size: list[float] | None,
    unit: float | None,
    tip_radius: float | None,
    form: str | int | None,
) -> rc.HeightMap:
    treatment = {"non_measured": options.non_measured, **_options_of_reader(options, path)}
    cell = None if path != options.surface else _sides(options.cell)
    surface = rc.read_surface(path, size=_sides(size), cell=cell, unit=unit, **treatment)
    if tip_radius is not None:
        surface = surface.restored(tip_radius)
    # Detrended and filtered before it is interpolated, so that the fit uses every measured point.
    surface = surface if form is None else surface.detrend(form)
    if options.shortest is None and options.longest is None:
        refuse(options, ("robust",), "is for filters: give --longest or --shortest too.")
        return surface
    return surface.filtered(options.shortest, options.longest, robust=options.robust)


def _options_of_reader(options: argparse.Namespace, path: str) -> dict[str, Any]:
    """Return the options for the reader of one map: all that are given, but those that are for the other map alone."""
    given = {name: getattr(options, name) for name in list_reader_options() if getattr(options, name) is not None}
    maps = [Path(name) for name in (options.surface, getattr(options, "counterbody", None)) if name is not None]
    others = {name for file in maps for name in options_of(file) if name not in options_of(Path(path))}
    return {name: value for name, value in given.items() if name not in others}


def _resample(surface: rc.HeightMap, options: argparse.Namespace) -> rc.HeightMap:
    if options.resample is None:
        return surface
    require_memory_of_solve(rc.Grid(options.resample, surface.size), rc.Boundary(options.boundary))
    return surface.resample(options.resample)


def _sides(lengths: list[float] | None) -> float | list[float] | None:
    return lengths[0] if lengths and len(lengths) == 1 else lengths


def _describe_counterbody_material(options: argparse.Namespace) -> Any:
    if all(getattr(options, f"counterbody_{name}") is None for name in MATERIALS):
        names = ("counterbody_hardness", "counterbody_poisson")
        refuse(options, names, "needs --counterbody-young: without it the counterbody is rigid.")
        refuse(options, ("counterbody_fields",), "needs --counterbody-material: without it the counterbody is rigid.")
        return "rigid"
    return _describe_material(options, "counterbody_", 0.3 if options.poisson is None else options.poisson)


def _describe_material(options: argparse.Namespace, prefix: str = "", poisson: float = 0.3) -> Any:
    """Return the material that options of this prefix name or describe, with this Poisson's ratio if they lack one."""
    relaxing = getattr(options, f"{prefix}viscoelastic")
    if relaxing is not None:
        option = f"--{prefix.replace('_', '-')}viscoelastic"
        refuse(
            options,
            (prefix + part for part in ("poisson", "hardness")),
            f"is for a Young's modulus: omit it with {option}.",
        )
        return make_part(rc.materials, option, "viscoelastic", relaxing)
    name: str | None = getattr(options, f"{prefix}material")
    fields: list[str] | None = getattr(options, f"{prefix}fields")
    if fields is not None or (name is not None and name not in TYPICAL):
        return _make_material(options, prefix, name, fields or [])
    constants = {part: getattr(options, prefix + part) for part in ("young", "poisson", "hardness")}
    if name is None:
        return {"poisson": poisson, **{part: value for part, value in constants.items() if value is not None}}
    names = (prefix + part for part in ("poisson", "hardness"))
    refuse(options, names, f"is for a Young's modulus: {name!r} has its own.")
    return name


def _make_material(options: argparse.Namespace, prefix: str, name: str | None, fields: Sequence[str]) -> rc.Material:
    """Return the material with a registered name and fields."""
    option = f"--{prefix.replace('_', '-')}material"
    if name is None or name in TYPICAL:
        allowed = f"one of {', '.join(rc.materials)}, whose fields follow --{prefix.replace('_', '-')}fields"
        raise rc.InputError.about(option, name, allowed)
    names = (f"{prefix}poisson", f"{prefix}hardness")
    refuse(options, names, f"is for a Young's modulus: omit it with {option} {name}, or give it as a field.")
    material: rc.Material = make_part(rc.materials, option, name, fields)
    return material


_LOADS = ("pressure", "force", "approach")


@attrs.frozen(eq=False)
class Scene:
    """A problem at a load, and a name for it, also of a folder, that is empty if there is only one."""

    name: str
    problem: rc.ContactProblem
    load: dict[str, Any]


def add_scenes(parser: argparse.ArgumentParser) -> None:
    """Declare height maps and a load, or a study file."""
    add_problem(parser, study=True)
    parser.usage = f"{parser.usage}\n       %(prog)s STUDY.toml [--problem NAME] [options]"
    parser.add_argument("--problem", metavar="NAME", help="one problem of a study file (all)")


def read_scenes(options: argparse.Namespace) -> list[Scene]:
    """Return what the options describe; of a study file every problem with every seed at every load.

    A load among the options replaces those of the study.
    """
    loaded = any(getattr(options, name) is not None for name in _LOADS)
    if not options.surface.lower().endswith(".toml"):
        if all(getattr(options, name) is None for name in MATERIALS) or not loaded:
            raise rc.InputError(
                "Height maps need --young, --material or --viscoelastic, and one of --pressure, --force and --approach."
            )
        if options.problem is not None:
            raise rc.InputError("--problem is for a study file: give that instead of maps, or omit the option.")
        return [Scene("", problem_of(options), loads_of(options)[0].arguments)]
    from roughcontact._work.studies.toml import read_study

    _refuse_options_of_maps(options)
    study = read_study(options.surface)
    if options.problem is not None and options.problem not in study.problems:
        raise rc.InputError.unknown("problem of the study", options.problem, study.problems)
    loads = [loads_of(options)[0].arguments] if loaded else [load.arguments for load in study.loads]
    scenes = []
    for chain in study.chains():
        if options.problem in (None, chain.name):
            problem, seed = (chain.problem, "") if chain.seed is None else (chain.seeded, f"-seed-{chain.seed}")
            for load in loads:
                (value,) = load.values()
                scenes.append(Scene(re.sub(r"[^\w.+-]", "_", f"{chain.name}{seed}-{value:g}"), problem, load))
    return scenes if len(scenes) > 1 else [attrs.evolve(scenes[0], name="")]


def _refuse_options_of_maps(options: argparse.Namespace) -> None:
    """Refuse what the study file states itself."""
    plain = argparse.ArgumentParser()
    add_problem(plain, study=True)
    defaults = vars(plain.parse_args([options.surface]))
    for name, default in defaults.items():
        if name not in _LOADS and getattr(options, name) != default:
            shown = "A second file" if name == "counterbody" else f"--{name.replace('_', '-')}"
            raise rc.InputError(f"{shown} is for height maps: a study file states its problems itself.")
