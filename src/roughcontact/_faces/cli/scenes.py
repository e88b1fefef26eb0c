"""The contacts that a command is asked about: height maps under a load, or the problems and loads of a study file."""

from __future__ import annotations

import argparse
import re
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._faces.cli.options import add_problem
from roughcontact._faces.cli.problem import loads_of, problem_of

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
        if (options.young is None and options.material is None) or not loaded:
            raise rc.InputError(
                "Height maps need --young or --material, and one of --pressure, --force and --approach."
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
