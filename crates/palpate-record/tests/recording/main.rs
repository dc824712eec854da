//! Recordings as files: what is written is read, and what is not there is said.

mod columns;
mod common;
mod contacts;
mod counted;
mod damage;
mod devices;
mod export;
mod files;
mod golden;
mod kill;
mod others;
mod whole;
