//! Nobody but the person who sees the printed address gets anything out of `rotund view`, and
//! nobody can make it fail.

mod access;
mod messages;
mod viewer;
