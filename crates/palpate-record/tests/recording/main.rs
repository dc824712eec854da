//! Round trips of recordings through files, and reports of missing data.

mod columns;
mod common;
mod contacts;
mod counted;
mod damage;
mod devices;
mod documented;
mod export;
mod files;
mod golden;
mod kill;
mod others;
mod whole;
