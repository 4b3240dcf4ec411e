//! What things are called in the window: files and numbers. Imports no other module of the editor.

pub mod figures;
pub mod files;
