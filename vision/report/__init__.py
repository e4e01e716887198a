"""One recording, one calibration or one diagnosis, as one HTML page that needs nothing beside itself."""

from vision.report.calibration_page import CalibrationResult, write_calibration_report
from vision.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
from vision.report.page import write_report

__all__ = [
    "CalibrationResult",
    "DiagnosisResult",
    "write_calibration_report",
    "write_diagnosis_report",
    "write_report",
]
