"""What runs in a process of its own: reading maps, planning, solving, drawing."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import math
import pickle
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from roughcontact import ContactProblem, ContactSolution, CoupledProcess, FrictionalPath, ProjectedConjugateGradient
from roughcontact.errors import InputError, RoughContactError
from roughcontact.faces import explain_loads, prepare_path, run_sweep
from roughcontact.plotting import panels
from roughcontact.results import AdhesionCycle, Increment, LoadPath, Sweep
from roughcontact.typing import Array, Load, binary, pair_constants, replacing, si

from roughcontact_app import film
from roughcontact_app.answers import (
    describe_cycle,
    describe_fretting,
    describe_path,
    describe_sweep,
    list_warnings,
)
from roughcontact_app.outputs import CourseOutputs, Offers, Outputs, PathOutputs, draw
from roughcontact_app.preview import describe as describe_surface
from roughcontact_app.progress import Progress
from roughcontact_app.responses import ask, ask_states
from roughcontact_app.roughness import describe_roughness
from roughcontact_app.scene import (
    Scene,
    ShownSurface,
    Upload,
    inspect_file,
    make_loads,
    make_problem,
    make_scene,
    require_solvable,
)
from roughcontact_app.settings import (
    PREFIXES,
    Settings,
    WrongSetting,
    asked_responses,
    fretting_values,
    is_path,
    path_values,
    read_settings,
)
from roughcontact_app.words import end_sentence, in_words_of_page

# How the time of a solve is estimated.
_BASIS = (
    "The time is that of the solve, without what is ticked, pictures and report, estimated from the cells and a "
    "transform timed here; "
    "it may be a third or three times that."
)
_CORRECTED = (
    "The time is that of the solve, without what is ticked, pictures and report, estimated from the cells and a "
    "transform timed here, "
    "corrected by the runs before."
)
_TOGETHER = (
    "The time is that of the solve, without what is ticked, pictures and report. What the material changes is solved "
    "together with the contact, in steps that it finds itself: it may be a fifth or five times that."
)
_FILM = (
    "The time is that of contacts and flows, without pictures, from the cells alone; it may be a third or three times "
    "that."
)

# Time that a solve takes at least, s; and that of a fretting cycle, of unlike and of like materials: at least, s, and
# over what more a solve takes. Measured on balls and rough surfaces of 64 to 512 cells along a side.
_MINIMUM_OF_SOLVE = 0.1
_COST_UNLIKE = (2.0, 450.0)
_COST_LIKE = (0.4, 70.0)
# The same of a process that is solved together with the contact: 500 to 6000 of balls on steel that flows below them.
_COST_COUPLED = (0.3, 1800.0)
# Increments of a step that a path with friction takes at most; and what another path takes from one time or sliding
# distance to the next, over a solve: 5.9 and 6.5 on rough surfaces of 512 cells along a side, less on smaller ones.
_MOST_INCREMENTS = 16
_INCREMENTS = 6
# States of a fretting cycle of like materials on the way to the first turn: half of those from turn to turn.
_STATES_TO_TURN = 4

# What is kept of the last run that was solved or asked for here, by its folder, and where each run is saved in its own.
_HELD: dict[str, Offers] = {}
_SAVED = "run.pickle"
# Scenes that took longer to make, s, are shared between the processes: so many of them.
_WORTH_SHARING = 0.02
_SHARED = 4
# What is solved ahead: whatever a first solve must load and plan is then there.
_TINY = {"surface": "self-affine", "cells": "32", "shortest": "25"}

Send = Callable[[dict[str, Any]], None]


@attrs.frozen
class Sources:
    """What scenes are made of: the files of body and counterbody, and the folder of shared scenes."""

    uploads: tuple[Upload | None, Upload | None] = (None, None)
    scenes: str = ""


# The beginnings of settings that the surface does not follow from: they do not make it anew.
_MATERIAL = ("young", "poisson", "hardness", "material", "moduli", "relaxation")
_OF_BODIES = tuple(f"{whose}{name}" for whose in PREFIXES for name in _MATERIAL)
_OF_OTHERS = (
    *_OF_BODIES,
    *(f"{whose}layer" for whose in PREFIXES),
    "adhesion",
    "work",
    "range",
    "friction",
    "load",
    "path",
    "time",
    "sliding",
    "law_",
    "cycle",
    "states",
    "normal_force",
    "tangential_force",
    "separations",
    "mirror_borders",
    "sampling",
    "film_units",
    "scheme",
    "ask_",
)
_OTHERS = ("counterbody",)


def run(task: dict[str, Any], send: Send) -> dict[str, Any]:
    """Return the result of a task, plain data that JSON can hold, after events sent on the way."""
    upload, counterbody = (
        None if task.get(name) is None else Upload(*task[name]) for name in ("upload", "counterbody_upload")
    )
    sources = Sources((upload, counterbody), task.get("scenes", ""))
    settings = read_settings(task["settings"])
    kinds: dict[str, Callable[[], dict[str, Any]]] = {
        "inspect": lambda: dict(inspect_file(upload)) if upload else {},
        "surface": lambda: _show_surfaces(settings, sources, Path(task["folder"])),
        "roughness": lambda: _describe_roughness(settings, sources, Path(task["folder"])),
        "plan": lambda: _plan(settings, sources, task["calibration"]),
        "solve": lambda: _solve(settings, sources, Path(task["folder"]), send),
        "file": lambda: _write_file(task["folder"], task["file"]),
        "state": lambda: _draw_state(settings, task),
    }
    try:
        return kinds[task["kind"]]()
    except InputError as error:
        raise WrongSetting(in_words_of_page(error), getattr(error, "setting", "")) from error


def warm_up() -> None:
    """Solve a contact, so that the first run need not load and plan what that takes."""
    problem, loads = _prepare(read_settings(_TINY), Sources())
    describe_sweep(_run(problem, loads, lambda _: None), {})


@functools.lru_cache(maxsize=1)
def _cached_scene(key: str, sources: Sources) -> Scene:
    if not sources.scenes:
        return make_scene(read_settings(json.loads(key)), *sources.uploads)
    shared = Path(sources.scenes) / f"{hashlib.sha256(f'{key} {sources.uploads}'.encode()).hexdigest()}.pickle"
    # This session has written it, in its private folder.
    with contextlib.suppress(OSError), shared.open("rb") as file:
        kept: Scene = pickle.load(file)
        return kept
    started = time.perf_counter()
    made = make_scene(read_settings(json.loads(key)), *sources.uploads)
    if time.perf_counter() - started > _WORTH_SHARING:
        # Where the disk is full, each process makes its own.
        with contextlib.suppress(OSError, RoughContactError):
            _keep(made, shared)
            for old in sorted(shared.parent.glob("*.pickle"), key=lambda one: one.stat().st_mtime)[:-_SHARED]:
                old.unlink(missing_ok=True)
    return made


def _keep(made: object, path: Path) -> None:
    with replacing(path, flush=False) as unfinished, unfinished.open("wb") as file:
        pickle.dump(made, file, pickle.HIGHEST_PROTOCOL)


def _scene(settings: Settings, sources: Sources) -> Scene:
    """Return the scene: the last one of this process, or of another, if its settings have not changed."""
    own = {name: text for name, text in settings.items() if name not in _OTHERS and not name.startswith(_OF_OTHERS)}
    return _cached_scene(json.dumps(own), sources)


def _show_surfaces(settings: Settings, sources: Sources, folder: Path) -> dict[str, Any]:
    """Return what is shown of the surface of the body, and under ``counterbody`` of that of the other."""
    scene = _scene(settings, sources)
    dark = settings["scheme"] == "dark"
    shown = _show(scene, scene.body, folder / "surface.png", dark)
    if scene.counterbody is not None:
        shown["counterbody"] = _show(scene, scene.counterbody, folder / "counterbody.png", dark)
    return shown


def _show(scene: Scene, one: ShownSurface, picture: Path, dark: bool) -> dict[str, Any]:
    shown = describe_surface(scene, one)
    try:
        draw(lambda: one.surface.plot(scene.grid, "map", dark=dark), picture)
        shown["picture"] = picture.name
    except RoughContactError as error:
        shown["note"] = in_words_of_page(error)
    return shown


def _describe_roughness(settings: Settings, sources: Sources, folder: Path) -> dict[str, Any]:
    scene = _scene(settings, sources)
    both = {"body": scene.body, "counterbody": scene.counterbody}
    dark = settings["scheme"] == "dark"
    return {
        "surfaces": [
            {"of": whose, **describe_roughness(one, scene.grid, folder / whose, dark)}
            for whose, one in both.items()
            if one is not None
        ]
    }


def _plan(settings: Settings, sources: Sources, calibration: float) -> dict[str, Any]:
    problem, loads = _prepare(settings, sources)
    if film.is_film(settings):
        return _plan_film(settings, problem)
    asked_responses(settings)
    plan = problem.plan
    together = _has_coupled(problem)
    takes = explain_loads(problem, loads)
    # What a material adds below the surface is known where it says so.
    added = 0.0 if math.isnan(takes.memory) else takes.memory
    light, most = (binary(memory + added) for memory in (plan.memory_at(0.0), plan.memory))
    beside = ", without what the material adds below the surface" if together and math.isnan(takes.memory) else ""
    return {
        "loads": [str(load) for load in loads],
        "solves": _count_solves(settings, problem, loads),
        "seconds": (1.0 if together else calibration) * _estimate_seconds(settings, problem, loads, takes.seconds),
        "memory": f"{light} at light contact, at most {most}{beside}",
        "basis": _TOGETHER if together else _BASIS if calibration == 1.0 else _CORRECTED,
        "text": str(takes),
        "warnings": [end_sentence(text) for text in plan.warnings],
    }


def _plan_film(settings: Settings, problem: ContactProblem) -> dict[str, Any]:
    found = film.plan(settings, problem)
    return {
        "loads": [f"{one:g} Sq" for one in found.separations],
        "solves": len(found.separations),
        "seconds": found.seconds,
        "memory": f"about {binary(found.memory)}",
        "basis": _FILM,
        "text": f"{found}\n\n{problem.explain()}",
        "warnings": [end_sentence(text) for text in problem.plan.warnings],
    }


def _prepare(settings: Settings, sources: Sources) -> tuple[ContactProblem, tuple[Load, ...]]:
    """Return the problem, of a path with the laws that its materials bring, and its loads; a film has none."""
    scene = _scene(settings, sources)
    if film.is_film(settings):
        scene = film.repeat_scene(settings, scene)
    problem = make_problem(settings, scene)
    require_solvable(settings, problem)
    if film.is_film(settings):
        return problem, ()
    if not is_path(settings):
        return problem, make_loads(settings, problem)
    normal, passed, accuracy = path_values(settings)
    problem, places = prepare_path(problem, normal, **passed, accuracy=accuracy)
    return problem, tuple(place.load for place in places)


def _solve(settings: Settings, sources: Sources, folder: Path, send: Send) -> dict[str, Any]:
    send({"phase": "preparing"})
    _HELD.clear()
    problem, loads = _prepare(settings, sources)
    dark = settings["scheme"] == "dark"
    if film.is_film(settings):
        law = film.solve(settings, problem, send)
        warnings = [end_sentence(in_words_of_page(text)) for text in law.warnings]
        outputs: Offers = film.FilmOutputs(law, settings["film_units"], folder, dark)
        return _offer(outputs, {"answers": film.describe(law), "warnings": warnings}, folder, send)
    forecast = _estimate_seconds(settings, problem, loads)
    started = time.perf_counter()
    result: Sweep | AdhesionCycle | FrictionalPath | LoadPath
    if is_path(settings):
        result = _run_path(problem, settings, len(loads), send)
    elif settings["load"] == "cycle":
        result = _run_cycle(problem, loads, send)
    elif settings["load"] == "fretting":
        result = _run_fretting(problem, settings, send)
    else:
        result = _run(problem, loads, send)
    ratio: float | None = (time.perf_counter() - started) / forecast
    send({"phase": "evaluating", "fraction": 1.0, "text": "The contact is solved; areas and uncertainties follow."})
    if isinstance(result, Sweep):
        asked, problems = ask(asked_responses(settings), result.states)
        answers = describe_sweep(result, asked)
        outputs = Outputs(result, asked, answers, folder, dark)
    elif isinstance(result, LoadPath):
        asked, problems = ask_states(asked_responses(settings), result.states)
        answers = describe_path(result, asked)
        outputs = CourseOutputs(result, asked, "path", folder, dark)
    else:
        asked, problems = ask_states(asked_responses(settings), result.states)
        is_cycle = isinstance(result, AdhesionCycle)
        describe: Callable[..., dict[str, Any]] = describe_cycle if is_cycle else describe_fretting
        answers = [describe(result, asked)]
        outputs = PathOutputs(result, asked, "cycle" if is_cycle else "loop", folder, dark)
    # The cost of a fretting cycle, of a path and of a coupled process depends on the answer: it says nothing of the
    # time of other runs.
    ratio = ratio if isinstance(result, (Sweep, AdhesionCycle)) and not _has_coupled(problem) else None
    found = {"answers": answers, "warnings": [*list_warnings(answers), *problems], "ratio": ratio}
    return _offer(outputs, found, folder, send)


def _offer(outputs: Offers, found: dict[str, Any], folder: Path, send: Send) -> dict[str, Any]:
    """Send what was found and what may be asked for of it; draw the first picture, and keep the rest for later."""
    files = outputs.list_files()
    send({"phase": "drawing", "fraction": 1.0, "text": "The first picture follows.", "outputs": files, **found})
    notes = []
    first = next(one["file"] for one in files if one["role"] == "picture")
    try:
        outputs.write(first)
        send({"made": first})
    except RoughContactError as error:
        notes.append(in_words_of_page(error))
    _HELD[str(folder)] = outputs
    try:
        _keep(outputs, folder / _SAVED)
    except RoughContactError as error:
        notes.append(in_words_of_page(error))
    except (pickle.PicklingError, AttributeError, TypeError):
        # A part of a plug-in cannot be kept: its files are there until this process has another run.
        pass
    return {"notes": notes}


def _write_file(folder: str, name: str) -> dict[str, Any]:
    """Write a file of a run that is done."""
    if folder not in _HELD:
        _HELD.clear()
        try:
            # This session has written it, in its private folder.
            with (Path(folder) / _SAVED).open("rb") as file:
                _HELD[folder] = pickle.load(file)
        except (EOFError, OSError, pickle.UnpicklingError):
            raise InputError("The fields of this run are not here any more: solve again.") from None
    _HELD[folder].write(name)
    return {}


def _count_solves(settings: Settings, problem: ContactProblem, loads: tuple[Load, ...]) -> int:
    """Return the number of states: unloading passes all states of loading but the last."""
    if settings["load"] == "fretting":
        return len(list_forces(problem, 1.0))
    return 2 * len(loads) - 1 if settings["load"] == "cycle" else len(loads)


def list_forces(problem: ContactProblem, most: float) -> list[tuple[float, float]]:
    """Return the tangential forces of a fretting cycle, N: to a turn, back and there again.

    Of like materials there are states between the turns, whose loop is a curve; of unlike ones each takes minutes.
    """
    if _are_unlike(problem):
        return [(most, 0.0), (-most, 0.0), (most, 0.0)]
    there = [most * step / _STATES_TO_TURN for step in range(-_STATES_TO_TURN + 1, _STATES_TO_TURN + 1)]
    return [(force, 0.0) for force in (*there[_STATES_TO_TURN:], *(-force for force in there), *there)]


def _estimate_seconds(
    settings: Settings, problem: ContactProblem, loads: tuple[Load, ...], beside: float = 0.0
) -> float:
    """Return the time of all states; `beside` is what the laws of each take beside its contact, s, if that is known."""
    seconds = problem.plan.seconds
    if beside > 0.0:
        seconds += beside
    elif _has_coupled(problem):
        minimum, ratio = _COST_COUPLED
        seconds = minimum + ratio * max(seconds - _MINIMUM_OF_SOLVE, 0.0)
    if is_path(settings):
        passes = bool(settings["time"] or settings["sliding"])
        return len(loads) * (_INCREMENTS if passes else 1) * seconds
    if settings["load"] != "fretting":
        return _count_solves(settings, problem, loads) * seconds
    minimum, ratio = _COST_UNLIKE if _are_unlike(problem) else _COST_LIKE
    return minimum + ratio * max(seconds - _MINIMUM_OF_SOLVE, 0.0)


def _has_coupled(problem: ContactProblem) -> bool:
    return any(isinstance(law, CoupledProcess) for law in problem.laws)


def _are_unlike(problem: ContactProblem) -> bool:
    return pair_constants(problem.body.material, problem.counterbody.material).beta != 0.0


def _run(problem: ContactProblem, loads: tuple[Load, ...], send: Send) -> Sweep:
    progress = Progress(problem.plan.grid.shape, len(loads), ProjectedConjugateGradient().tolerance, send)

    def solve(load: Load, start: Array | None) -> ContactSolution:
        progress.begin(str(load))
        return problem.solve(**load.arguments, start=start, throw=False, on_step=progress.step)

    if problem.adhesion is None:
        return run_sweep(solve, loads)
    # The state of surfaces that attract each other depends on the loads before.
    states: list[ContactSolution] = []
    for load in loads:
        states.append(solve(load, states[-1].pressure if states and states[-1].status.success else None))
    return Sweep(tuple(states))


def _run_cycle(problem: ContactProblem, loads: tuple[Load, ...], send: Send) -> AdhesionCycle:
    total = 2 * len(loads) - 1
    count = 0

    def tell(state: ContactSolution) -> None:
        nonlocal count
        count += 1
        branch = "loading" if count <= len(loads) else "unloading"
        text = f"state {count} of {total}, {branch}: approach {si(state.approach, 'm', 3)}"
        send({"phase": "solving", "fraction": count / total, "text": f"{text}, force {si(state.force, 'N', 3)}"})

    return problem.cycle(approach=[load.value for load in loads], on_state=tell)


def _run_fretting(problem: ContactProblem, settings: Settings, send: Send) -> FrictionalPath:
    normal, most, friction = fretting_values(settings)
    forces = list_forces(problem, most)
    send({"phase": "solving", "fraction": 0.0, "text": "The bodies are pressed together."})
    total = _MOST_INCREMENTS if _are_unlike(problem) else 1

    def tell(done: Increment) -> None:
        # The path has been followed with half as many increments before, a quarter and so on, and pressing is a step.
        part = (done.step + done.increment / done.increments) / (done.steps + 1)
        fraction = (done.increments - 1 + part * done.increments) / (2 * total - 1)
        doubled = f"; doubled, up to {total}, until the numbers hardly change" if total > 1 else ""
        send({"phase": "solving", "fraction": fraction, "text": f"{done}{doubled}"})

    return problem.path(force=normal, tangential_force=forces, friction=friction, on_increment=tell)


def _run_path(problem: ContactProblem, settings: Settings, total: int, send: Send) -> LoadPath:
    normal, passed, accuracy = path_values(settings)
    name, course = next(((name, values) for name, values in passed.items() if values), ("", []))
    count = 0

    def tell(state: ContactSolution) -> None:
        nonlocal count
        count += 1
        here = LoadPath(states=(state,), increments=(1,))
        # An increment leads to each load, but many from one time to the next.
        done = int(np.searchsorted(course, getattr(here, name)[0], side="right")) if course else min(count, total)
        text = f"state {min(done + 1, total)} of {total}, increment {count}: approach {si(state.approach, 'm', 3)}"
        send({"phase": "solving", "fraction": done / total, "text": f"{text}, force {si(state.force, 'N', 3)}"})

    return problem.path(**normal, **passed, accuracy=accuracy, on_increment=tell)


def _draw_state(settings: Settings, task: dict[str, Any]) -> dict[str, Any]:
    """Draw a panel of a state of a path whose fields lie in a file."""
    state = ContactSolution.load(task["file"], verify=False)
    panel = panels.create(task["panel"], **task["fields"])
    picture = Path(task["folder"]) / "state.png"
    draw(lambda: state.plot(panel, dark=settings["scheme"] == "dark"), picture)
    return {"picture": picture.name}
