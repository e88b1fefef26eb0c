"""What is published: all that is under version control, and nothing that lies around."""

from __future__ import annotations

import shutil
import subprocess
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STRAY = (".env", "passwords.txt", "src/.env", "src/{package}/.env", "tests/.netrc", "build.log")
# Of the repository alone.
UNPUBLISHED = (".dockerignore", ".git", "Dockerfile", ".pre-commit-config.yaml", ".zenodo.json", "paper/", "recipe/")


@pytest.mark.parametrize(
    ("folder", "package"),
    [(".", "roughcontact"), *((f"plugins/{one.name}", one.name.replace("-", "_")) for one in ROOT.glob("plugins/*-*"))],
)
def test_what_lies_around_is_not_published(tmp_path, folder, package):
    sdist = pytest.importorskip("hatchling.builders.sdist")
    wheel = pytest.importorskip("hatchling.builders.wheel")
    if not (ROOT / ".git").exists():
        pytest.skip("needs the repository")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT / folder, capture_output=True, text=True, check=True).stdout
    kept, tree = set(listed.splitlines()), tmp_path / "tree"
    for name in kept:
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / folder / name, tree / name)
    stray = {name.format(package=package) for name in STRAY}
    for name in stray:
        (tree / name).write_text("secret")
    (source,) = sdist.SdistBuilder(str(tree)).build(directory=str(tmp_path))
    (built,) = wheel.WheelBuilder(str(tree)).build(directory=str(tmp_path), versions=["standard"])
    with tarfile.open(source) as file:
        published = {name.partition("/")[2] for name in file.getnames()}
    assert not published & stray
    assert {name for name in kept if not name.startswith(UNPUBLISHED)} <= published
    with zipfile.ZipFile(built) as file:
        packed = {name for name in file.namelist() if ".dist-info" not in name}
    assert {f"src/{name}" for name in packed} == {name for name in kept if name.startswith(f"src/{package}/")}
