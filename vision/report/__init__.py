"""One recording as one HTML page that needs nothing beside itself."""

from vision.report.page import write_report

__all__ = ["write_report"]
