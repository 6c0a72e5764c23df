//! Stock laws.
