"""Names of the files in a folder of results: of one recording, of a diagnosis, of many recordings."""

RESULT = "result.json"
REPORT = "report.html"
FIGURES = "report.figures.json"
REFUSED = "refused.json"
RERUN = "recording.rrd"
FOXGLOVE = "foxglove.json"
PLOTJUGGLER = "plotjuggler.xml"
VIEWER_FILES = (FOXGLOVE, PLOTJUGGLER, RERUN)
"""files for Foxglove, PlotJuggler and Rerun; the last on request only"""
DATASET = "dataset.mcap"
OVERLAY = "overlay.mp4"
"""the arm in small, with markers and linkage drawn over it"""
STAGE_FILES = ("camera.yaml", "angles.mcap", OVERLAY, DATASET, "model.yaml", "simulated.mcap")
"""files that the stages write, not all of them for every recording"""
WATCHED_TRACKS = "watched.npz"
"""tracks of markers that `xneck watch` made of the growing video, which `run` goes on from; not a result"""
WATCH_FILES = (f"*/{WATCHED_TRACKS}",)
"""files that `watch` writes into the folder of results"""
ALL_FILES = (*STAGE_FILES, *VIEWER_FILES, REPORT, FIGURES, RESULT, REFUSED)

DIAGNOSIS_PAGE = "diagnosis.html"
DIAGNOSIS_RECORD = "diagnosis.json"
EXTENDED_NECK, EXTENDED_MODEL = "neck.yaml", "model.yaml"
DECIDING_MOTION = "motion.csv"
"""the motion that would settle a diagnosis, where it is not settled"""
DIAGNOSIS_FILES = (
    DIAGNOSIS_PAGE,
    "diagnosis.figures.json",
    EXTENDED_NECK,
    EXTENDED_MODEL,
    DECIDING_MOTION,
    DIAGNOSIS_RECORD,
)
DIAGNOSIS_FOLDER = "diagnosis"
"""folder, beside those of the recordings, with the diagnosis of all"""

SUMMARY_PAGE, SUMMARY_RECORD = "summary.html", "summary.json"
BATCH_FILES = (
    SUMMARY_PAGE,
    SUMMARY_RECORD,
    *(f"*/{name}" for name in ALL_FILES),
    *(f"{DIAGNOSIS_FOLDER}/{name}" for name in DIAGNOSIS_FILES),
)
"""files of many recordings, by patterns: a folder for each, and the summary of all"""

STUDY_TABLES, STUDY_RECORD, CASES_FOLDER = "study.md", "study.json", "cases"
STUDY_FILES = (STUDY_TABLES, STUDY_RECORD, f"{CASES_FOLDER}/*")
