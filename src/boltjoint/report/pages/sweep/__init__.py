"""The interactive page of a sweep."""
