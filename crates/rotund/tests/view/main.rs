//! Nobody but the person who sees the printed address gets anything out of `rotund view`, and
//! nobody can make it fail.

mod access;
#[cfg(unix)]
mod commands;
mod connections;
mod messages;
mod viewer;
