"""External evidence: values of other programs, of makers' catalogues and of classic theory, computed with these models."""
