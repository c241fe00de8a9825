//! The `.dsm` file format, and deep OpenEXR.
