"""Which tests a core is given as one: those of a file, and those of files that share what takes long to make."""

from pathlib import PurePosixPath

from xdist.scheduler import LoadFileScheduling

from tests.slow import TOGETHER


def together(file: str) -> str:
    """The name under which a file's tests go to one core: the file's own, or that of the first place it shares with others."""
    path = PurePosixPath(file)
    for places in TOGETHER:
        if any(path.is_relative_to(PurePosixPath("tests") / place) for place in places):
            return places[0]
    return file


class BySharedSetup(LoadFileScheduling):
    """xdist's own distribution by file, with some files as one."""

    def _split_scope(self, nodeid: str) -> str:
        return together(super()._split_scope(nodeid))
