//! One file per node.
