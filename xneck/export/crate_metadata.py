"""ro-crate-metadata.json of a folder of results: RO-Crate 1.1 (https://w3id.org/ro/crate/1.1).

What is in the package, what each file was made from, by which software, whose it is, and what others may do with it.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import quote

from xneck_foundation.errors import Refused
from xneck_foundation.version import VERSION

METADATA = "ro-crate-metadata.json"
Entity = dict[str, Any]
_CONTEXT = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]
_KINDS = {
    ".mcap": "application/octet-stream",
    ".csv": "text/csv",
    ".json": "application/json",
    ".yaml": "application/yaml",
    ".html": "text/html",
    ".xml": "application/xml",
    ".md": "text/markdown",
    ".pdf": "application/pdf",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".mp4": "video/mp4",
}
"""media types, by suffix"""
_WORDS = {
    "angles.mcap": "Joint angles in each frame of the video, with standard deviations, on the camera's clock",
    "camera.yaml": "The calibrated camera, as a ROS camera_info",
    "dataset.mcap": "Joint angles, motor angles and forces on the log's clock, with neck.yaml inside (ROS 2 JointState)",
    "diagnosis.html": "What the simulation gets wrong, and its cause, as a page",
    "diagnosis.json": "The diagnosis as a record",
    "model.yaml": "Laws and parameters of motors, cables and joints, with standard deviations",
    "motion.csv": "A motion for the controller: joint angles, motor angles and forces",
    "neck.yaml": "Description of the arm",
    "overlay.mp4": "The arm in the video, with markers and the fitted linkage drawn over it",
    "report.html": "One recording, from the camera to the identified parameters, as a page",
    "result.json": "Results of all stages of one recording as a record",
    "simulated.mcap": "The recorded forces through the identified model",
    "summary.html": "All recordings as a page",
    "summary.json": "All recordings as a record",
}
"""what a file is, by its name"""


@dataclass(frozen=True)
class PackageOptions:
    """What only a person can say of a package."""

    title: str | None = None
    licence: str | None = None
    """SPDX name or address"""
    authors: tuple[str, ...] = ()
    """names, with an ORCID in angle brackets behind where there is one"""
    date: str | None = None
    """of publication, YYYY-MM-DD"""


@dataclass(frozen=True)
class PackedFile:
    """A file in the package."""

    name: str
    """path in the package, with slashes"""
    bytes: int
    sha256: str
    as_written: bool
    """whether it is as xneck wrote it"""


@dataclass(frozen=True)
class Origin:
    """What the files of one folder were made from, as a record in it says."""

    record: str
    """path of the record in the package"""
    inputs: Mapping[str, Mapping[str, Any]]
    """by role: file, bytes, sha256"""
    software: Mapping[str, Any]
    """versions: xneck, python, libraries"""


def crate_metadata(
    title: str, date: str, options: PackageOptions, files: Sequence[PackedFile], origins: Sequence[Origin]
) -> dict[str, Any]:
    """The metadata document, ready for JSON. Raises Refused where licence or author cannot be read."""
    authors, licence = [_author(text, k) for k, text in enumerate(options.authors, start=1)], _licence(options.licence)
    identity = {file.sha256: _file_id(file.name) for file in reversed(files)}
    actions, further = _actions(files, origins, identity)
    root: Entity = {
        "@id": "./",
        "@type": "Dataset",
        "name": title,
        "description": "Results of xneck: what a cable-driven arm did, from a camera and encoder logs, and what its model lacks.",
        "datePublished": date,
        "hasPart": [{"@id": _file_id(file.name)} for file in files],
    }
    if authors:
        root["author"] = [{"@id": author["@id"]} for author in authors]
    if licence:
        root["license"] = {"@id": licence["@id"]}
    if actions:
        root["mentions"] = [{"@id": action["@id"]} for action in actions]
    descriptor: Entity = {
        "@id": METADATA,
        "@type": "CreativeWork",
        "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
        "about": {"@id": "./"},
    }
    people = [*authors, *([licence] if licence else [])]
    graph = [descriptor, root, *map(_file_entity, files), *people, *actions, *further]
    return {"@context": _CONTEXT, "@graph": graph}


def missing_words(options: PackageOptions, files: Sequence[PackedFile]) -> list[str]:
    """What the package does not say, or what in it is not xneck's, a sentence each."""
    lines = []
    if not options.licence:
        lines.append("no licence is named: nobody may use the data before you name one (--license)")
    if not options.authors:
        lines.append("no author is named (--author)")
    changed = [file.name for file in files if not file.as_written]
    if changed:
        lines.append(f"not written by xneck, or changed since: {', '.join(changed)}")
    return lines


def _file_id(name: str) -> str:
    return quote(name)


def _file_entity(file: PackedFile) -> Entity:
    path = PurePosixPath(file.name)
    entity: Entity = {
        "@id": _file_id(file.name),
        "@type": "File",
        "name": path.name,
        "contentSize": str(file.bytes),
        "sha256": file.sha256,
        "encodingFormat": _KINDS.get(path.suffix.lower(), "application/octet-stream"),
    }
    words = _WORDS.get(path.name, "Numbers of a page's figures" if path.name.endswith(".figures.json") else None)
    by = None if file.as_written else "Not written by xneck, or changed since."
    if described := ". ".join(filter(None, [words, by])):
        entity["description"] = described
    return entity


def _actions(
    files: Sequence[PackedFile], origins: Sequence[Origin], identity: Mapping[str, str]
) -> tuple[list[Entity], list[Entity]]:
    """What made the files of each folder with a record; and the inputs and software that they name."""
    actions, further = [], {}
    for number, origin in enumerate(origins, start=1):
        folder = PurePosixPath(origin.record).parent
        made = [f.name for f in files if PurePosixPath(f.name).parent == folder and f.as_written]
        software = _software(origin.software)
        further[software["@id"]] = software
        objects = []
        for role, entry in origin.inputs.items():
            key = str(entry.get("sha256", ""))
            if key not in identity:
                outside = {
                    "@id": f"#input-{key[:16]}",
                    "@type": "CreativeWork",
                    "name": str(entry.get("file", role)),
                    "description": f"An input that is not in this package ({role})",
                    "contentSize": str(entry.get("bytes", "")),
                    "sha256": key,
                }
                further[outside["@id"]] = outside
            objects.append({"@id": identity.get(key, f"#input-{key[:16]}")})
        actions.append(
            {
                "@id": f"#made-{number}",
                "@type": "CreateAction",
                "name": f"What made the files beside {origin.record}",
                "instrument": {"@id": software["@id"]},
                "object": objects,
                "result": [{"@id": _file_id(name)} for name in made],
            }
        )
    if not origins:
        software = _software({"xneck": VERSION})
        further[software["@id"]] = software
    return actions, list(further.values())


def _software(versions: Mapping[str, Any]) -> Entity:
    version = str(versions.get("xneck", VERSION))
    libraries = versions.get("libraries") or {}
    words = ", ".join(
        [f"Python {versions.get('python', '')}".strip(), *(f"{k} {v}" for k, v in libraries.items() if v)]
    )
    return {
        "@id": f"#xneck-{version}",
        "@type": "SoftwareApplication",
        "name": "xneck",
        "version": version,
        "softwareRequirements": words,
    }


def _licence(text: str | None) -> Entity | None:
    """The licence as an entity: an SPDX name, or the address of its text."""
    if text is None:
        return None
    if re.fullmatch(r"https?://[^\s<>\"]+", text):
        return {"@id": text, "@type": "CreativeWork", "name": text}
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]*", text):
        return {"@id": f"https://spdx.org/licenses/{text}", "@type": "CreativeWork", "name": text}
    raise Refused(
        "--license", f"{text!r} is neither an SPDX name nor an address", "such as CC-BY-4.0, see spdx.org/licenses"
    )


def _author(text: str, number: int) -> Entity:
    """A person, known by an ORCID where there is one."""
    found = re.fullmatch(r"\s*([^<>]*[^<>\s])\s*(?:<\s*(?:https://orcid\.org/)?([0-9X-]+)\s*>)?\s*", text)
    if found is None:
        raise Refused("--author", f"{text!r} is not NAME or NAME <ORCID>", "such as 'A. Person <0000-0002-1825-0097>'")
    name, orcid = found.groups()
    if orcid is not None and not _is_orcid(orcid):
        raise Refused(
            "--author", f"{orcid} is no ORCID", "copy it from orcid.org: four groups of four, the last one a check"
        )
    identity = f"https://orcid.org/{orcid}" if orcid else f"#author-{number}"
    return {"@id": identity, "@type": "Person", "name": name}


def _is_orcid(text: str) -> bool:
    """Whether the last character is the check of the others (ISO 7064, 11-2)."""
    if not re.fullmatch(r"\d{4}-\d{4}-\d{4}-\d{3}[\dX]", text):
        return False
    total = 0
    for digit in text.replace("-", "")[:-1]:
        total = 2 * (total + int(digit))
    check = (12 - total % 11) % 11
    return text[-1] == ("X" if check == 10 else str(check))
