"""The import graph of the product: lines per room, circles among modules, imports that go up.

    python -m benchmarks.import_graph

Rooms and their order are those of the layers in pyproject.toml. Imports for type checkers only (`if TYPE_CHECKING`) run nothing
and are left out; imports inside functions count.
"""

import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Room:
    """A package of the top level."""

    name: str
    layer: int
    """from the top; rooms of one layer know nothing of each other"""
    modules: int
    lines: int


@dataclass(frozen=True)
class House:
    """What the import graph shows."""

    rooms: tuple[Room, ...]
    """top first"""
    circles: tuple[tuple[str, ...], ...]
    """modules that import each other, directly or by way of others"""
    upward: tuple[tuple[str, str], ...]
    """importing module, imported module of a room above or beside it"""

    def share(self, room: Room) -> float:
        """The room's part of all lines."""
        return room.lines / sum(other.lines for other in self.rooms)

    def text(self) -> str:
        """A table of the rooms, and a line for each circle and each upward import."""
        rows = [f"{'room':18}{'layer':>6}{'modules':>9}{'lines':>8}{'share':>8}"]
        rows += [f"{r.name:18}{r.layer:6}{r.modules:9}{r.lines:8}{100 * self.share(r):7.1f}%" for r in self.rooms]
        rows.append(f"{'':18}{'':6}{sum(r.modules for r in self.rooms):9}{sum(r.lines for r in self.rooms):8}")
        rows.append(f"circles among modules: {len(self.circles)}")
        rows += [f"  {' <-> '.join(circle)}" for circle in self.circles]
        rows.append(f"upward imports: {len(self.upward)}")
        rows += [f"  {importer} -> {imported}" for importer, imported in self.upward]
        return "\n".join(rows)


def house(root: Path = ROOT) -> House:
    """The import graph of the packages that pyproject.toml lists."""
    layers = room_layers(root)
    graph = grimp.build_graph(*layers, exclude_type_checking_imports=True, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in sorted(graph.modules)}
    files = {module: _source(root, module) for module in imports}
    rooms = []
    for name, layer in layers.items():
        modules = [m for m in imports if m.split(".")[0] == name]
        lines = sum(len(files[m].read_text(encoding="utf-8").splitlines()) for m in modules)
        rooms.append(Room(name, layer, len(modules), lines))
    upward = tuple(
        (importer, imported)
        for importer, targets in imports.items()
        for imported in sorted(targets)
        if _goes_up(layers, importer.split(".")[0], imported.split(".")[0])
    )
    return House(tuple(rooms), circles(imports), upward)


def room_layers(root: Path = ROOT) -> dict[str, int]:
    """The layer of each room by the layers contract of pyproject.toml, 0 at the top."""
    linter = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (contract,) = [c for c in linter["contracts"] if c["type"] == "layers" and "xneck" in c["layers"]]
    return {name.strip(): k for k, layer in enumerate(contract["layers"]) for name in layer.split("|")}


def circles(imports: Mapping[str, set[str]]) -> tuple[tuple[str, ...], ...]:
    """Strongly connected components of more than one module, by Tarjan's algorithm."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[tuple[str, ...]] = []

    def visit(module: str) -> None:
        index[module] = low[module] = len(index)
        stack.append(module)
        for target in sorted(imports.get(module, ())):
            if target not in index:
                visit(target)
                low[module] = min(low[module], low[target])
            elif target in stack:
                low[module] = min(low[module], index[target])
        if low[module] == index[module]:
            start = stack.index(module)
            component, stack[start:] = sorted(stack[start:]), []
            if len(component) > 1:
                found.append(tuple(component))

    for module in sorted(imports):
        if module not in index:
            visit(module)
    return tuple(sorted(found))


def _goes_up(layers: Mapping[str, int], importer: str, imported: str) -> bool:
    return importer != imported and layers[imported] <= layers[importer]


def _source(root: Path, module: str) -> Path:
    path = root.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


if __name__ == "__main__":
    measured = house()
    print(measured.text())
    sys.exit(1 if measured.circles or measured.upward else 0)
