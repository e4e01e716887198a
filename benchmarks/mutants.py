"""How many small slips in a package its tests notice: mutants by mutmut, drawn at random, each run against the mirrored tests.

    python -m benchmarks.mutants --package mechanism --sample 50

A mutant is one change of one function: a sign, an index, a number, a left-out argument. It is noticed where a fast test of
`tests/PACKAGE`, or one of those given, that calls the function fails or does not end. What changes nothing that anyone could
see is listed in `benchmarks/equivalent_mutants.py` with its reason, and is not counted. All happens in a copy of the sources.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

import click
import numpy as np

from benchmarks.equivalent_mutants import EQUIVALENT
from benchmarks.figures.rate import Rate
from tests.slow import is_slow

ROOT = Path(__file__).parents[1]
RECORD = ROOT / "benchmarks/record/mutants.json"
_SURVIVED, _NO_TESTS = 0, 33
"""mutmut's exit codes of mutants that no test noticed; with the second no test calls the function at all"""
_NONE = "none.of.them"
"""a name that no mutant has: mutmut then makes them all and learns which tests call what, and runs none"""
_LEFT_OUT = (
    ".git",
    ".venv",
    "__pycache__",
    "*.pyc",
    "out",
    ".pytest_cache",
    ".ruff_cache",
    "*.egg-info",
    "node_modules",
)
_CONFIGURATION = """
[tool.mutmut]
source_paths = ["{package}/"]
pytest_add_cli_args_test_selection = {tests}
pytest_add_cli_args = ["-p", "no:cacheprovider"]
also_copy = {others}
"""


@dataclass(frozen=True)
class Survivor:
    """A mutant that no test noticed."""

    function: str
    """with its module, such as `mechanism.geometry.span`"""
    before: str
    """the line that was changed"""
    after: str
    called: bool
    """whether any test calls the function"""

    @property
    def equivalent(self) -> str | None:
        """Why it changes nothing that anyone could see; None where it does."""
        return EQUIVALENT.get((self.function, self.after))


@dataclass(frozen=True)
class Score:
    """Mutants of a package that were drawn, and those that the tests did not notice."""

    package: str
    mutants: int
    """that there are"""
    drawn: int
    survivors: tuple[Survivor, ...]

    @property
    def rate(self) -> Rate:
        """Noticed, of those that are not equivalent."""
        equivalent = sum(survivor.equivalent is not None for survivor in self.survivors)
        return Rate(self.drawn - len(self.survivors), self.drawn - equivalent)


def score(package: str, sample: int, seed: int, children: int = 2, tests: Sequence[str] = ()) -> Score:
    """Of a package by its path, such as `mechanism/laws`: so many mutants drawn at random.

    tests: files that are run too though they are slow, beside the fast ones of the mirrored folder; all of it where none is."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "tree"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*_LEFT_OUT))
        others = sorted(path.name for path in copy.iterdir() if path.is_dir())
        text = _CONFIGURATION.format(
            package=package,
            tests=json.dumps([*_fast_tests(copy / _tests_of(package), copy), *tests] or [_tests_of(package)]),
            others=json.dumps(others),
        )
        with (copy / "pyproject.toml").open("a", encoding="utf-8") as file:
            file.write(text)
        said = _mutmut(copy, "run", "--max-children", str(children), _NONE)
        names = sorted(_exit_codes(copy))
        if not names:
            raise RuntimeError(f"mutmut made no mutants:\n{said[-2000:]}")
        rng = np.random.default_rng(seed)
        chosen = sorted(rng.choice(names, min(sample, len(names)), replace=False).tolist())
        _mutmut(copy, "run", "--max-children", str(children), *chosen)
        codes = _exit_codes(copy)
        unfinished = [name for name in chosen if codes[name] is None]
        if unfinished:
            raise RuntimeError(f"mutmut did not run {', '.join(unfinished)}")
        left = [name for name in chosen if codes[name] in (_SURVIVED, _NO_TESTS)]
        survivors = tuple(_survivor(copy, name, codes[name] == _SURVIVED) for name in left)
    return Score(package, len(names), len(chosen), survivors)


def _tests_of(package: str) -> str:
    """The folder of tests that mirrors a package, or that it is tested in with others."""
    folder = Path("tests") / package
    while not (ROOT / folder).is_dir():
        folder = folder.parent
    return folder.as_posix()


def _fast_tests(folder: Path, root: Path) -> list[str]:
    """Files of a folder that are not named slow as a whole."""
    files = [path.relative_to(root / "tests").as_posix() for path in sorted(folder.rglob("test_*.py"))]
    return [f"tests/{file}" for file in files if not is_slow(file)]


def _mutmut(copy: Path, *words: str) -> str:
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": ""}
    command = [sys.executable, "-W", "ignore", "-m", "mutmut", *words]
    done = subprocess.run(command, cwd=copy, env=os.environ | one_thread, capture_output=True, text=True, check=False)
    if done.returncode and _NONE not in words:
        raise RuntimeError(f"mutmut {words[0]} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def _exit_codes(copy: Path) -> dict[str, int | None]:
    """Of every mutant by its name; None where it was not run."""
    codes: dict[str, int | None] = {}
    for file in sorted((copy / "mutants").rglob("*.meta")):
        codes |= json.loads(file.read_text(encoding="utf-8"))["exit_code_by_key"]
    return codes


def _survivor(copy: Path, name: str, called: bool) -> Survivor:
    lines = _mutmut(copy, "show", name).splitlines()
    before, after = (
        " ".join(line[1:].strip() for line in lines if line.startswith(sign) and not line.startswith(3 * sign))
        for sign in ("-", "+")
    )
    # mutmut's names: module.x_function__mutmut_7, module.xǁClassǁmethod__mutmut_7
    module, _, function = name.rpartition("__mutmut_")[0].rpartition(".")
    plain = function.removeprefix("x").strip("ǁ_" if "ǁ" not in function else "ǁ").replace("ǁ", ".")
    return Survivor(f"{module}.{plain}", before, after, called)


def as_markdown(scores: Sequence[Score]) -> str:
    """A table of scores, and what was not noticed."""
    lines = ["| package | mutants | drawn | noticed | of those | 95 % interval |", "|---|---|---|---|---|---|"]
    for s in scores:
        equivalent = s.drawn - s.rate.of
        drawn = f"{s.drawn}" + (f", {equivalent} equivalent" if equivalent else "")
        lines.append(
            f"| `{s.package}` | {s.mutants} | {drawn} | {s.rate.text} | {s.rate.percent} | {s.rate.interval} |"
        )
    for s in scores:
        lines += ["", f"Not noticed in `{s.package}`:", ""] if s.survivors else []
        for survivor in s.survivors:
            why = survivor.equivalent or ("" if survivor.called else "no test calls it")
            lines.append(
                f"- `{survivor.function}`: `{survivor.before}` -> `{survivor.after}`" + (f" ({why})" if why else "")
            )
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
@click.option("--package", "packages", multiple=True, default=("mechanism/laws", "mechanism"), show_default=True)
@click.option("--sample", type=click.IntRange(1), default=50, show_default=True, help="mutants of each package")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--children", type=click.IntRange(1), default=2, show_default=True, help="processes at once")
@click.option("--tests", multiple=True, help="a slow file of tests that is run too")
@click.option("--record", is_flag=True, help="put the scores into benchmarks/record/mutants.json")
def main(
    packages: tuple[str, ...], sample: int, seed: int, children: int, tests: tuple[str, ...], record: bool
) -> None:
    for package in packages:
        found = score(package, sample, seed, children, tests)
        print(as_markdown([found]), flush=True)
        if record:
            known = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
            day = datetime.now(UTC).date().isoformat()
            known[package] = asdict(found) | {"seed": seed, "day": day, "noticed": found.rate.text}
            RECORD.write_text(
                json.dumps(dict(sorted(known.items())), indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
            )


if __name__ == "__main__":
    main()
