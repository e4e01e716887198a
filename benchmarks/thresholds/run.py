"""Every world judged as things are, then with each threshold at half and at twice: one line of JSON a judgement."""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.patching import patched
from benchmarks.thresholds.room import Room, World
from benchmarks.thresholds.threshold import Threshold

Line = dict[str, Any]


def run(room: Room, folder: Path) -> Iterator[Line]:
    """Judgements that folder/ROOM.jsonl lacks, each appended to it as soon as it is made."""
    file = folder / f"{room.name}.jsonl"
    folder.mkdir(parents=True, exist_ok=True)
    done = {_key(line) for line in read_lines(file)}
    tried = [(None, "", None), *((t, which, value) for t in room.thresholds() for which, value in t.tried)]
    for world in room.worlds(folder / room.name):
        asked = [(t, which, value) for t, which, value in tried if (t and t.label, which, world.name) not in done]
        if not asked:
            continue
        with room.kept() as forget:
            for threshold, which, value in asked:
                if forget is not None:
                    forget()
                line = _judged(room, world, threshold, which, value)
                with file.open("a", encoding="utf-8") as lines:
                    lines.write(json.dumps(line) + "\n")
                yield line


def read_lines(file: Path) -> list[Line]:
    """What was judged before; the last line may have been cut off."""
    if not file.exists():
        return []
    text = file.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        file.write_text(whole, encoding="utf-8")
    return [json.loads(line) for line in whole.splitlines()]


def _judged(room: Room, world: World, threshold: Threshold | None, which: str, value: Any) -> Line:
    begin = time.monotonic()
    if threshold is None:
        outcome: Outcome = room.judged(world)
    else:
        with patched(threshold.module, threshold.name, value):
            outcome = room.judged(world)
    return {
        "threshold": threshold and threshold.label,
        "which": which,
        "value": f"{value:g}" if isinstance(value, int | float) else str(value) if isinstance(value, tuple) else "",
        "world": world.name,
        "right": outcome.right,
        "false": outcome.false,
        "said": outcome.said,
        "seconds": round(time.monotonic() - begin, 2),
    }


def _key(line: Line) -> tuple[str | None, str, str]:
    return line["threshold"], line["which"], line["world"]
