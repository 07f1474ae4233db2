//! What the search has found.
