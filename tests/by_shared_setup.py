"""A core is given the tests of a file as one, and those of files that share what takes long to make."""

from xdist.scheduler import LoadFileScheduling

from tests.slow import together


class BySharedSetup(LoadFileScheduling):
    """xdist's own distribution by file, with some files as one."""

    def _split_scope(self, nodeid: str) -> str:
        return together(super()._split_scope(nodeid))
