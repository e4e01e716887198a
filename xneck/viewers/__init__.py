"""What other people's viewers open: Rerun, Foxglove, PlotJuggler."""
