"""Files of the format with something changed and their checksums right again, so that what is left to notice is the
change itself: `mutations` of check_validator.py. Written from docs/format/dsm-1.md."""
