"""``roughcontact report`` and ``roughcontact stability``: how far to trust the answer of a solve."""

from __future__ import annotations

import argparse
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.units import fit
from roughcontact._faces.cli import Command
from roughcontact._faces.cli.answers import describe_rows, write_json
from roughcontact._faces.cli.help import leave_to
from roughcontact._faces.cli.options import NUMBER, whole_number
from roughcontact._faces.cli.problem import Scene, add_scenes, read_scenes
from roughcontact._faces.cli.progress import show_progress
from roughcontact._faces.panels.theme import require_matplotlib
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import describe_inputs, describe_solution, describe_value
from roughcontact._solve.solution import DEFAULT_AREA
from roughcontact._work.reports import UNITS, ErrorReport, StabilityReport, Verdict


class Report(Command):
    """Compare grids, area estimators, kernels, solvers and tolerances: error against run time."""

    epilog = """
examples:
  roughcontact report map.npz --pressure 10MPa --young 210GPa
  roughcontact report map.npz --pressure 10MPa --young 210GPa \\
      --cells 64 128 256 --areas blend cell-count -o comparison
  roughcontact report study.toml --problem ball --force 5N
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_scenes(parser)
        compared = parser.add_argument_group("choices to compare; every combination is solved")
        compared.add_argument(
            "--cells",
            type=whole_number,
            nargs="+",
            metavar="N",
            help="cells along x (an eighth, a quarter, half and all)",
        )
        compared.add_argument("--areas", nargs="+", metavar="NAME", help="area estimators (blend cell-count)")
        compared.add_argument("--kernels", nargs="+", metavar="NAME", help="kernels (as --kernel)")
        compared.add_argument("--solvers", nargs="+", metavar="NAME", help="solvers (as --solver)")
        tolerances = "tolerances of the solvers"
        interpolation = "interpolation of the maps on other grids (bilinear)"
        timed = "timed solves per case (3)"
        kinds = ("bilinear", "fourier", "mean")
        leave_to(
            "method",
            compared.add_argument("--tolerances", type=NUMBER, nargs="+", metavar="T", help=tolerances),
            compared.add_argument("--interpolation", choices=kinds, default=kinds[0], help=interpolation),
            compared.add_argument("--repeats", type=whole_number, default=3, metavar="R", help=timed),
        )
        folder = "contact-report"
        parser.add_argument("-o", "--output", default=folder, metavar="FOLDER", help=f"output folder ({folder})")
        parser.add_argument("--json", action="store_true", help="print one JSON object: inputs, reference and cases")

    def run(self, options: argparse.Namespace) -> int:
        """Solve all cases, print the table and the advice, write CSV, Markdown and picture; return 0."""
        require_matplotlib()
        output = checks.path(options.output, "The output folder")
        described = []
        for scene in read_scenes(options):
            folder = output / scene.name
            folder.mkdir(parents=True, exist_ok=True)
            report = _compare(options, scene)
            advice = report.advice()
            described.append({**_name(scene), **_describe(report, scene)})
            if not options.json:
                print(f"{_heading(scene)}{fit(advice)}\n\n{report}")
            report.to_csv(folder / "report.csv")
            with replacing(folder / "report.md") as partial:
                partial.write_text(f"{report.to_markdown()}\n{advice}\n", encoding="utf-8")
            report.draw(folder / "report.png")
            if not options.json:
                print(fit(f"\nWritten to {folder}: report.csv, report.md, report.png"))
        if options.json:
            print(write_json(described[0] if len(described) == 1 else {"reports": described}))
        return 0


def _describe(report: ErrorReport, scene: Scene) -> dict[str, Any]:
    """Return a report as data that JSON can hold; its cases have the columns of report.csv."""
    known = report.reference
    quantities = {
        name: {**describe_value(getattr(known, name), UNITS[name]), "error_bound": getattr(known, f"{name}_error")}
        for name in known.quantities
    }
    return {
        "inputs": describe_inputs(scene.problem, [Load.signed(**scene.load)]),
        "advice": report.advice(),
        "reference": {"source": known.source, **quantities},
        "cases": describe_rows(report.table()),
    }


def _name(scene: Scene) -> dict[str, str]:
    """Return the name of a scene as data; nothing of the only one."""
    return {"name": scene.name} if scene.name else {}


def _heading(scene: Scene) -> str:
    return f"\n{scene.name}\n" if scene.name else ""


def _compare(options: argparse.Namespace, scene: Scene) -> ErrorReport:
    with show_progress("solving") as change:
        return rc.error_vs_time(
            scene.problem,
            **scene.load,
            cells=options.cells,
            areas=options.areas or (DEFAULT_AREA, "cell-count"),
            kernels=options.kernels,
            solvers=options.solvers,
            tolerances=options.tolerances,
            interpolation=options.interpolation,
            repeats=options.repeats,
            on_case=lambda case, fraction: change(f"{case}, {100 * fraction:.0f} % done", fraction),
        )


class Stability(Command):
    """Test how the answer of a solve depends on rounding, cells and tolerances."""

    epilog = """
examples:
  roughcontact stability map.npz --pressure 10MPa --young 210GPa
  roughcontact stability study.toml --problem ball --force 5N
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_scenes(parser)
        parser.add_argument("--area", metavar="NAME", help="area estimator to report besides the default")
        parser.add_argument("--json", action="store_true", help="print one JSON object: inputs, verdict and checks")

    def run(self, options: argparse.Namespace) -> int:
        """Return 0, or 1 if a check of any contact fails."""
        estimator = None if options.area is None else rc.areas.resolve(options.area)
        status = 0
        described = []
        for scene in read_scenes(options):
            with show_progress("solving") as change:
                report = rc.stability(scene.problem, **scene.load, on_check=change)
            status = max(status, int(report.verdict is Verdict.FAIL))
            if options.json:
                described.append({**_name(scene), **_describe_checks(report, scene, options.area)})
                continue
            print(f"{_heading(scene)}{report}")
            if estimator is not None:
                print(fit(f"area: {report.solution.area(estimator)}"))
        if options.json:
            print(write_json(described[0] if len(described) == 1 else {"reports": described}))
        return status


def _describe_checks(report: StabilityReport, scene: Scene, estimator: str | None) -> dict[str, Any]:
    """Return the checks of a contact, in the order in which they were made, and its solution, as data for JSON."""
    solution = describe_solution(report.solution, estimator)
    del solution["inputs"]
    return {
        "inputs": describe_inputs(scene.problem, [Load.signed(**scene.load)]),
        "verdict": str(report.verdict),
        "checks": [{**attrs.asdict(check), "verdict": str(check.verdict)} for check in report.checks],
        "solution": solution,
    }
