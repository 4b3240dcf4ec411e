//! The program as a user of the command line meets it. What is measured of a process is measured of the program's own.

mod auto;
mod bake;
mod bake_layers;
mod bake_shares;
mod bench;
mod checkpoints;
mod commands;
mod diff;
mod foreign_files;
mod inputs;
mod killing;
mod measure;
mod missing;
#[cfg(feature = "window")]
mod monkey;
mod odd_numbers;
mod pictures;
mod sequences;
mod shares;
mod submit;
mod submit_bake;
mod volumes;
mod why;
mod workshop;
