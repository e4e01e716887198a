"""What every room stands on: errors, strict YAML, whole files, provenance, version, least squares."""
