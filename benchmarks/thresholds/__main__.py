"""python -m benchmarks.thresholds [ROOM...] [--out FOLDER] [--count]: what half and twice of each threshold do to verdicts.

Every room's worlds are judged as things are and with each threshold changed, one line of JSON a judgement in FOLDER. It takes hours
for all rooms; a run that was stopped goes on where it was. At the end the counts go into benchmarks/record/thresholds.json, from
which `python -m benchmarks.figures` fills docs/thresholds.md. With --count nothing is judged.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.thresholds import calibration, check, clocks, diagnosis
from benchmarks.thresholds.record import RECORD, counted, read_record, write_record
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.run import read_lines, run

ROOMS: dict[str, Room] = {
    room.name: room
    for room in (diagnosis.ROOM, diagnosis.FITS, diagnosis.SIGNATURES, check.ROOM, clocks.ROOM, calibration.ROOM)
}


def main(words: Sequence[str]) -> int:
    """Command line; 130 where it was interrupted."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.thresholds",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help=f"of {', '.join(ROOMS)}; all by default")
    parser.add_argument("--out", type=Path, default=Path("out/thresholds"), help="folder (default: %(default)s)")
    parser.add_argument("--count", action="store_true", help="judge nothing, and count what was judged before")
    chosen = parser.parse_args(words)
    if unknown := [name for name in chosen.rooms if name not in ROOMS]:
        parser.error(f"there is no room {unknown[0]}; there are {', '.join(ROOMS)}")
    rooms = [ROOMS[name] for name in chosen.rooms or ROOMS]
    try:
        for room in () if chosen.count else rooms:
            for line in run(room, chosen.out):
                print(
                    f"{room.name}: {line['threshold'] or 'as it is'} {line['which']}, {line['world']}: {line['said']}",
                    flush=True,
                )
    except KeyboardInterrupt:
        print("benchmarks: interrupted; what is done is kept", file=sys.stderr)
        return 130
    record = read_record() if RECORD.exists() else {}
    for room in rooms:
        if lines := read_lines(chosen.out / f"{room.name}.jsonl"):
            record[room.name] = counted(lines)
    write_record(record)
    print(RECORD)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
