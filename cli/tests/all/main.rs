//! All tests of the command and of the scene reader, as one program.

mod command;
mod common;
mod examples;
mod modules;
mod names;
mod references;
mod scene;
mod scene_mistakes;
mod stable;
mod study;
mod sweep;
mod sweep_folder;
