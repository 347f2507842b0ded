//! Order-independent transparency: the methods, the CPU backend, temporal accumulation.
