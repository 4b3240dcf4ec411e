//! What things are called in the window: parameters, kinds, files and numbers. Imports no other module of the editor.

pub mod figures;
pub mod files;
pub mod kinds;
mod of_lights;
mod of_materials;
pub mod parameter;
pub mod parameters;
