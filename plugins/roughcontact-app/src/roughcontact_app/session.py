"""What one start of the app holds: its token, the uploads, the processes of its pages, and the runs."""

from __future__ import annotations

import json
import secrets
import threading
from collections import OrderedDict
from pathlib import Path
from typing import Any

import attrs
from roughcontact.errors import InputError

from roughcontact_app.folder import PrivateFolder
from roughcontact_app.jobs import Jobs
from roughcontact_app.laws import LAW_BOXES
from roughcontact_app.material_fields import list_typical
from roughcontact_app.materials import MATERIAL_FORMS
from roughcontact_app.page import Page
from roughcontact_app.responses import TICK_BOXES
from roughcontact_app.scene import EXAMPLES
from roughcontact_app.settings import DEFAULTS, FIRST, Settings, read_settings
from roughcontact_app.uploads import PartialFile, StoredFile, Uploads, known_endings

# Bytes that reading a file may take: some for libraries, and a multiple of its bytes, of which a height may have one.
_LIBRARIES = 2**29
_OVER_FILE = 40
# Seconds that reading a map, or planning a solve, may take.
_PATIENCE = 120.0
# Pages whose processes are kept; that of the page that was used longest ago is started again when it is needed.
_PAGES = 4
# Pictures of surfaces that are kept: one for each change of the form of the page.
_PICTURES = 24


class Session:
    """All that the requests of pages, each by a name of its own, come to; its folder is private and ends with it."""

    def __init__(self, *, slots: int | None = None, patience: float = _PATIENCE):
        self.token = secrets.token_urlsafe(24)
        self._private = PrivateFolder()
        self.folder = self._private.path
        parts = {name: self.folder / name for name in ("uploads", "surfaces", "scenes", "runs")}
        for part in parts.values():
            part.mkdir(mode=0o700)
        self.uploads = Uploads(parts["uploads"])
        self.jobs = Jobs(parts["runs"], slots, patience)
        self._scenes = parts["scenes"]
        self._surfaces = parts["surfaces"]
        self._patience = patience
        self._pages: OrderedDict[str, Page] = OrderedDict()
        self._opening = threading.Lock()
        self._pictures: OrderedDict[str, bytes] = OrderedDict()

    def prepare(self) -> None:
        """Start the process of the first run, and return at once."""
        threading.Thread(target=self.jobs.prepare, daemon=True).start()

    def describe(self, page: str) -> dict[str, Any]:
        """Return what a page must know at its start, and start what it will soon need."""
        threading.Thread(target=self._start_processes, args=(page,), daemon=True).start()
        return {
            "defaults": DEFAULTS,
            "first": FIRST,
            "examples": list(EXAMPLES),
            "typical": list_typical(),
            "materials": [attrs.asdict(form) for form in MATERIAL_FORMS.values()],
            "endings": known_endings(),
            "responses": [attrs.asdict(box) for box in TICK_BOXES.values()],
            "laws": [attrs.asdict(box) for box in LAW_BOXES.values()],
        }

    def upload(self, partial: PartialFile, page: str, body: str = "") -> dict[str, Any]:
        """Return digest, name and facts of a file that a page has sent for one of its bodies."""
        return self._inspect(self.uploads.finish(partial), page, body)

    def find_upload(self, digest: object, page: str, body: str = "") -> dict[str, Any]:
        """Return whether a file is still here, with its name and facts."""
        file = self.uploads.find(str(digest))
        return {"here": False} if file is None else {"here": True, **self._inspect(file, page, body)}

    def _inspect(self, file: StoredFile, page: str, body: str) -> dict[str, Any]:
        reader = self._page(page)
        task = self._task("inspect", read_settings({"file": file.digest}), reader.folder)
        task["memory"] = _LIBRARIES + _OVER_FILE * file.size
        return {"digest": file.digest, "name": file.name, "facts": reader.inspect(task, file.name, body)}

    def show_surface(self, data: object, page: str) -> dict[str, Any]:
        """Return numbers, warnings and the name of the picture of the surface that the settings describe."""
        maker = self._page(page)
        settings = read_settings(data)
        with maker.making:
            shown = maker.make(self._task("surface", settings, maker.folder), "Making the surface")
            for one in filter(None, (shown, shown.get("counterbody"))):
                if "picture" in one:
                    one["picture"] = self._keep(maker.folder / one["picture"])
        return shown

    def describe_roughness(self, data: object, page: str) -> dict[str, Any]:
        """Return the numbers of the roughness of the surfaces, and the names of their pictures."""
        maker = self._page(page)
        task = self._task("roughness", read_settings(data), maker.folder)
        with maker.making:
            found = maker.make(task, "Measuring the roughness")
            for surface in found["surfaces"]:
                for one in surface["pictures"]:
                    one["picture"] = self._keep(maker.folder / surface["of"] / one["picture"])
        return found

    def plan(self, data: object, page: str) -> dict[str, Any]:
        """Return what a run will do and cost."""
        return self._plan(read_settings(data), self._page(page))

    def _plan(self, settings: Settings, maker: Page) -> dict[str, Any]:
        task = self._task("plan", settings, maker.folder)
        with maker.making:
            found = maker.make(task, "Planning the solve")
            maker.planned = _name_problem(task)
        return found

    def draw_state(self, data: object, page: str) -> dict[str, Any]:
        """Return the name of the picture of a panel of a state of a path that has been followed."""
        asked = data if isinstance(data, dict) else {}
        job = self.jobs.find(str(asked.get("run")))
        shown = {} if job is None else {one["panel"]: one for one in job.describe()["outputs"] if "states" in one}
        panel = shown.get(str(asked.get("panel")))
        number = asked.get("state")
        if job is None or panel is None or type(number) is not int or not 1 <= number <= len(panel["states"]):
            raise InputError("There is no picture of such a state here any more: solve again.")
        maker = self._page(page)
        task = self._task("state", job.settings, maker.folder) | {"panel": panel["panel"], "fields": panel["fields"]}
        task["file"] = str(self.jobs.write_file(job, f"solution-{number}.npz"))
        with maker.making:
            return {"picture": self._keep(maker.folder / maker.make(task, "Drawing the state")["picture"])}

    def start(self, data: object, page: str) -> dict[str, Any]:
        """Start a run, and return what is known of it."""
        settings = read_settings(data)
        # What cannot run is refused now, and not when its turn has come; what the page has just planned can.
        maker = self._page(page)
        with maker.making:
            if maker.planned != _name_problem(self._task("plan", settings, maker.folder)):
                self._plan(settings, maker)
        return self.jobs.describe(self.jobs.add(settings, lambda folder: self._task("solve", settings, folder)))

    def _start_processes(self, page: str) -> None:
        self._page(page).start()
        self.jobs.prepare()

    def _page(self, name: str) -> Page:
        """Return the processes of a page."""
        with self._opening:
            if name not in self._pages:
                self._pages[name] = Page(self._surfaces / secrets.token_hex(8), self._patience)
            self._pages.move_to_end(name)
            while len(self._pages) > _PAGES:
                self._pages.popitem(last=False)[1].close()
            return self._pages[name]

    def picture(self, name: str) -> bytes | None:
        """Return a picture of a surface, if it is still kept."""
        return self._pictures.get(name)

    def close(self) -> None:
        """End all processes and remove all files."""
        self.jobs.close()
        for page in self._pages.values():
            page.close()
        self._private.close()

    def _keep(self, path: Path) -> str:
        name = secrets.token_hex(8)
        self._pictures[name] = path.read_bytes()
        while len(self._pictures) > _PICTURES:
            self._pictures.popitem(last=False)
        return name

    def _task(self, kind: str, settings: Settings, folder: Path) -> dict[str, Any]:
        is_wanted = settings["surface"] == "file" or kind == "inspect"
        file = self.uploads.find(settings["file"]) if is_wanted else None
        is_wanted = settings["counterbody_surface"] == "file"
        other = self.uploads.find(settings["counterbody_file"]) if is_wanted else None
        return {
            "kind": kind,
            "settings": dict(settings),
            "upload": None if file is None else [str(file.path), file.name],
            "counterbody_upload": None if other is None else [str(other.path), other.name],
            "folder": str(folder),
            "scenes": str(self._scenes),
            "calibration": self.jobs.calibration,
        }


def _name_problem(task: dict[str, Any]) -> str:
    """Return a text that differs where what is planned may differ."""
    return json.dumps([task["settings"], task["upload"], task["counterbody_upload"]])
