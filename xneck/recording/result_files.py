"""Names of the files in a folder of one recording's results."""

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
STAGE_FILES = ("camera.yaml", "angles.mcap", DATASET, "model.yaml", "simulated.mcap")
"""files that the stages write, not all of them for every recording"""
ALL_FILES = (*STAGE_FILES, *VIEWER_FILES, REPORT, FIGURES, RESULT, REFUSED)
