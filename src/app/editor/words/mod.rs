//! Texts of the window about files, numbers and times. Imports no other module of the editor.

pub mod arithmetic;
pub mod figures;
pub mod files;
pub mod times;
