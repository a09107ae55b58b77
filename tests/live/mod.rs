//! Live tracking over real sockets: our own ends, broken ends, and programs that others wrote.

mod connections;
mod faults;
mod load;
mod peers;
mod vectors;
