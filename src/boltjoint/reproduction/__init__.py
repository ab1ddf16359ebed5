"""Values of the thesis beside those of a study: tables, captions, statements, indices."""
