"""Prints constraints that hold every run-time dependency of pyproject.toml to the oldest series of versions that it allows."""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def lower_bounds(project: Path) -> list[str]:
    """Such as `numpy==2.1.*`, the oldest series that is allowed of each dependency. Raises ValueError where one has no bound."""
    out = []
    for dependency in tomllib.loads(project.read_text(encoding="utf-8"))["project"]["dependencies"]:
        found = re.match(r"([A-Za-z0-9._-]+)(?:\[[^\]]*\])?>=([0-9.]+)", dependency)
        if found is None:
            raise ValueError(f"{dependency}: no lower bound")
        out.append(f"{found[1]}=={found[2]}.*")
    return out


if __name__ == "__main__":
    print("\n".join(lower_bounds(PROJECT)))
