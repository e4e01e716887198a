"""One recording, one calibration, one diagnosis or one batch, as one HTML page that needs nothing beside itself."""
