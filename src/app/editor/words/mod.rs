//! Texts of the window about files and numbers. Imports no other module of the editor.

pub mod figures;
pub mod files;
