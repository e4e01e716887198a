"""The product's files in the order in which a run first calls a function of each, and the ways from room to room.

    python -m benchmarks.files_entered samples/held_out       `xneck run` of one recording
    python -m benchmarks.files_entered --effect tip_payload   two recordings with a hidden effect, to its diagnosis

What runs while a module is imported is left out. A way goes up where a lower room calls a function
of a higher one, which it can only have been given: such as what shows progress.
"""

import argparse
import inspect
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from types import CodeType, FrameType

from benchmarks.import_graph import ROOT, room_layers

SECONDS = (20.0, 16.0)
"""length of the recordings with an effect: fitted, held out"""
SEED = 7011


@dataclass(frozen=True)
class Call:
    """A call from one file of the product into another, as it first happened."""

    caller: str | None
    """None where the caller is no file of the product"""
    file: str
    function: str

    @property
    def rooms(self) -> tuple[str | None, str]:
        """Rooms of the caller and of the function."""
        return None if self.caller is None else self.caller.split("/")[0], self.file.split("/")[0]


@dataclass
class CallRecorder:
    """Records calls between the files below `root` that belong to one of `rooms`."""

    root: Path
    rooms: Collection[str]
    calls: dict[tuple[str | None, str], Call] = field(default_factory=dict)
    """by caller and file, in the order of their first calls"""
    _files: dict[CodeType, str | None] = field(default_factory=dict)
    _seen: set[tuple[CodeType, CodeType | None]] = field(default_factory=set)

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Calls inside this block are recorded, those of threads that it starts too."""
        before = sys.gettrace()
        sys.settrace(self._record)
        threading.settrace(self._record)
        try:
            yield
        finally:
            sys.settrace(before)
            threading.settrace(before)  # type: ignore[arg-type]

    def _record(self, frame: FrameType, event: str, argument: object) -> None:
        """Python calls this as each function begins; no line of it is traced."""
        pair = (frame.f_code, frame.f_back.f_code if frame.f_back else None)
        if pair in self._seen:
            return
        file = self._file(frame.f_code)
        if file is not None:
            if _while_importing(frame):
                return  # the run itself may call the function again
            caller = frame.f_back
            while caller is not None and self._file(caller.f_code) is None:
                caller = caller.f_back
            by = None if caller is None else self._file(caller.f_code)
            if by != file:
                self.calls.setdefault((by, file), Call(by, file, frame.f_code.co_qualname))
        self._seen.add(pair)

    def _file(self, code: CodeType) -> str | None:
        """Path below the root of a function of the product; None for all other code, and for bodies of modules and classes."""
        if code not in self._files:
            self._files[code] = None
            if code.co_flags & inspect.CO_OPTIMIZED and code.co_filename.startswith(f"{self.root}{os.sep}"):
                file = Path(code.co_filename).relative_to(self.root)
                if file.parts[0] in self.rooms:
                    self._files[code] = file.as_posix()
        return self._files[code]


def _while_importing(frame: FrameType) -> bool:
    """Whether a module that is being imported leads to this frame."""
    outer: FrameType | None = frame
    while outer is not None:
        if outer.f_code.co_name == "<module>" and outer.f_globals.get("__name__") != "__main__":
            return True
        outer = outer.f_back
    return False


def recorded_calls(run: Callable[[], object], root: Path = ROOT) -> list[Call]:
    """The calls between files of the product while `run` runs, in their order."""
    recorder = CallRecorder(root, room_layers(root))
    with recorder.recording():
        run()
    return [*recorder.calls.values()]


def text(calls: list[Call], layers: Mapping[str, int]) -> str:
    """The files in the order in which they are entered, the rooms in that order, and the ways between rooms."""
    entries: dict[str, Call] = {}
    ways: dict[tuple[str, str], list[Call]] = {}
    for call in calls:
        entries.setdefault(call.file, call)
        caller_room, room = call.rooms
        if caller_room is not None and caller_room != room:
            ways.setdefault((caller_room, room), []).append(call)
    rows = enumerate(entries.values(), start=1)
    lines = [f"{k:4}  {e.file:60} {e.function:40} <- {e.caller or '-'}" for k, e in rows]
    sequence = groupby(entries.values(), lambda entry: entry.rooms[1])
    lines += ["", "rooms as the next file is entered (files entered there):"]
    lines.append("  " + " -> ".join(f"{room} ({len([*files])})" for room, files in sequence))
    lines += ["", "ways from room to room (pairs of files):"]
    for (caller, room), pairs in sorted(ways.items(), key=lambda way: [layers[name] for name in way[0]]):
        goes_up = layers[room] <= layers[caller]
        lines.append(f"  {'UP  ' if goes_up else 'down'}  {caller} -> {room}  {len(pairs)}")
        lines += [f"          {call.caller} -> {call.file} {call.function}" for call in pairs if goes_up]
    return "\n".join(lines)


def run_recording(folder: Path) -> None:
    """`xneck run` of one recording folder, into a folder that is thrown away."""
    from xneck.cli import group

    with tempfile.TemporaryDirectory() as out:
        group.main(["run", str(folder), "--out", out, "--quiet"], standalone_mode=False)


def run_effect(effect: str, folder: Path) -> None:
    """From two recordings with a hidden effect to its diagnosis; the generator of recordings is no part of the product."""
    import xneck

    fitted, held_out = (xneck.synchronise(folder / name) for name in ("fitted", "held_out"))
    estimates = xneck.identify([fitted])
    from identification.model_file import model_of

    xneck.simulate(fitted, model_of(estimates.parameters, estimates.laws, {}, estimates.covariance))
    print(f"hidden: {effect}; diagnosed: {xneck.diagnose([fitted], [held_out]).verdict}", file=sys.stderr)


def main() -> None:
    """What the words on the command line ask for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.files_entered", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("recording", nargs="?", type=Path, help="a recording folder")
    parser.add_argument("--effect", help="an effect of the generator, to be hidden and diagnosed")
    options = parser.parse_args()
    if (options.recording is None) == (options.effect is None):
        parser.error("name a recording folder, or an effect")
    if options.recording is not None:
        calls = recorded_calls(lambda: run_recording(options.recording.resolve()))
    else:
        from samples.generator.hidden.experiment import hide

        with tempfile.TemporaryDirectory() as folder:
            hide([options.effect], SEED, Path(folder), seconds=SECONDS)
            calls = recorded_calls(lambda: run_effect(options.effect, Path(folder)))
    print(text(calls, room_layers()))


if __name__ == "__main__":
    main()
