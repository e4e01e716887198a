"""Prints the exact versions of the development tools in this environment, with all that only they need, as constraints.

What the package itself needs at run time is not held: its users have other versions too, and CI tries the newest and the oldest.
"""

import tomllib
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def closure(dependencies: list[str]) -> set[str]:
    """Names of all that these dependencies need here."""
    names: set[str] = set()
    todo = [Requirement(dependency) for dependency in dependencies]
    while todo:
        requirement = todo.pop()
        name = canonicalize_name(requirement.name)
        if name in names:
            continue
        try:
            needs = distribution(name).requires or []
        except PackageNotFoundError:
            continue
        names.add(name)
        for need in map(Requirement, needs):
            extras = requirement.extras or {""}
            if need.marker is None or any(need.marker.evaluate({"extra": extra}) for extra in extras):
                todo.append(need)
    return names


if __name__ == "__main__":
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    tools = closure([*project["optional-dependencies"]["dev"], *project["optional-dependencies"]["mutation"]])
    for name in sorted(tools - closure(project["dependencies"])):
        print(f"{name}=={version(name)}")
