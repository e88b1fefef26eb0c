"""What one start of the page holds: its token, the uploads, the process that reads maps, and the runs."""

from __future__ import annotations

import secrets
import tempfile
import threading
from collections import OrderedDict
from io import BufferedIOBase
from pathlib import Path
from typing import Any

from roughcontact.app.jobs import Jobs
from roughcontact.app.process import Worker
from roughcontact.app.scene import EXAMPLES
from roughcontact.app.settings import DEFAULTS, Settings, read_settings
from roughcontact.app.uploads import StoredFile, Uploads, known_endings

# Seconds that reading a map, or planning a solve, may take.
_PATIENCE = 120.0
# Pictures of surfaces that are kept: one for each change of the form of the page.
_PICTURES = 24


class Session:
    """All that the requests of a page come to; its folder is private and ends with it."""

    def __init__(self, *, slots: int | None = None, patience: float = _PATIENCE):
        self.token = secrets.token_urlsafe(24)
        # Made for this user alone (mode 700).
        self._temporary = tempfile.TemporaryDirectory(prefix="roughcontact-app-", ignore_cleanup_errors=True)
        folder = Path(self._temporary.name)
        parts = {name: folder / name for name in ("uploads", "surfaces", "runs")}
        for part in parts.values():
            part.mkdir(mode=0o700)
        self.uploads, self.jobs = Uploads(parts["uploads"]), Jobs(parts["runs"], slots)
        self._surfaces, self._patience = parts["surfaces"], patience
        # One change of the form after the other: the process keeps the last surface.
        self._reader, self._reading = Worker(), threading.Lock()
        self._pictures: OrderedDict[str, bytes] = OrderedDict()

    def describe(self) -> dict[str, Any]:
        """Return what the page must know at its start, and start what it will soon need."""
        threading.Thread(target=self._prepare, daemon=True).start()
        return {"defaults": DEFAULTS, "examples": list(EXAMPLES), "endings": known_endings()}

    def upload(self, source: BufferedIOBase, size: int, name: str) -> dict[str, Any]:
        """Return digest, name and facts of a file that the page sends."""
        return self._inspect(self.uploads.receive(source, size, name))

    def find_upload(self, digest: str) -> dict[str, Any]:
        """Return whether a file is still here, with its name and facts."""
        file = self.uploads.find(digest)
        return {"here": False} if file is None else {"here": True, **self._inspect(file)}

    def _inspect(self, file: StoredFile) -> dict[str, Any]:
        facts = self._read("inspect", read_settings({"file": file.digest}))
        return {"digest": file.digest, "name": file.name, "facts": facts}

    def show_surface(self, data: object) -> dict[str, Any]:
        """Return numbers, warnings and the name of the picture of the surface that the settings describe."""
        with self._reading:
            shown = self._do("surface", read_settings(data))
            if "picture" in shown:
                shown["picture"] = self._keep(self._surfaces / "surface.png")
        return shown

    def plan(self, data: object) -> dict[str, Any]:
        """Return what a run will do and cost."""
        return self._read("plan", read_settings(data))

    def start(self, data: object) -> dict[str, Any]:
        """Start a run, and return what is known of it."""
        settings = read_settings(data)
        # What cannot run is refused now, and not when its turn has come.
        self._read("plan", settings)
        return self.jobs.describe(self.jobs.add(settings, lambda folder: self._task("solve", settings, folder)))

    def _prepare(self) -> None:
        self._reader.start()
        self.jobs.prepare()

    def picture(self, name: str) -> bytes | None:
        """Return a picture of a surface, if it is still kept."""
        return self._pictures.get(name)

    def close(self) -> None:
        """End all processes and remove all files."""
        self.jobs.close()
        self._reader.close()
        self._temporary.cleanup()

    def _keep(self, path: Path) -> str:
        name = secrets.token_hex(8)
        self._pictures[name] = path.read_bytes()
        while len(self._pictures) > _PICTURES:
            self._pictures.popitem(last=False)
        return name

    def _read(self, kind: str, settings: Settings) -> dict[str, Any]:
        with self._reading:
            return self._do(kind, settings)

    def _do(self, kind: str, settings: Settings) -> dict[str, Any]:
        return self._reader.do(self._task(kind, settings, self._surfaces), self._patience)

    def _task(self, kind: str, settings: Settings, folder: Path) -> dict[str, Any]:
        file = self.uploads.find(settings["file"]) if settings["surface"] == "file" or kind == "inspect" else None
        return {
            "kind": kind,
            "settings": dict(settings),
            "upload": None if file is None else [str(file.path), file.name],
            "folder": str(folder),
            "calibration": self.jobs.calibration,
        }
