"""Results for other tools: the arm for MuJoCo, figures for papers, packages for archives, tables for pandas and xarray."""
