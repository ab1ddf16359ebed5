"""Pages of the report: templates, style, and the modules that fill them."""
