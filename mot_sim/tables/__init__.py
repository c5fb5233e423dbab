"""Tables: one type, with a writer for each format."""
