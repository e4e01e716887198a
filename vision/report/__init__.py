"""One recording, or one calibration, as one HTML page that needs nothing beside itself."""

from vision.report.calibration_page import CalibrationResult, write_calibration_report
from vision.report.page import write_report

__all__ = ["CalibrationResult", "write_calibration_report", "write_report"]
