"""python -m benchmarks.command_process decode VIDEO | COMMAND...: decodes, or runs an xneck command, and says what that took.

The last line of standard output: seconds of processor time, and the peak of memory in MB.
"""

import resource
import sys
from pathlib import Path

STATUS = Path("/proc/self/status")


def spent() -> float:
    """Processor time of this process and those that it started, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def peak() -> float:
    """MB. The kernel's count for a process begins with what its parent held, its status does not."""
    if STATUS.is_file():
        line = next(line for line in STATUS.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024 / 1e6
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def main(words: list[str]) -> int:
    """The status of what was run."""
    status: object = 0
    if words[0] == "decode":
        from vision.video import read_frames

        for _ in read_frames(Path(words[1])):
            pass
    else:
        from xneck.cli import main as xneck

        sys.argv = ["xneck", *words]
        try:
            xneck()
        except SystemExit as ended:
            status = ended.code
    print(spent(), peak())
    return status if isinstance(status, int) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
