"""Draw reports from records of tables, figures and texts, and write them as web pages; imports no model."""
