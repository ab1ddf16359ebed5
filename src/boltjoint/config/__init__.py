"""The configuration of a study: typed sections, strict YAML and JSON schemas."""
