"""The figures of the report, one function each."""
