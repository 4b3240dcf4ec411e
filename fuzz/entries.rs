//! Every parser that reads foreign bytes, as a plain function of these bytes.
//!
//! The fuzz target and the test that replays the corpus share this file and those in `entries`, so that both do the
//! same. An entry panics where the program breaks a promise: a panic of the parser itself, a mesh that contradicts its
//! documentation, a document that changes when it is written.

#[path = "entries/beside.rs"]
mod beside;
#[path = "entries/documents.rs"]
pub mod documents;
#[path = "entries/folders.rs"]
mod folders;
#[path = "entries/meshes.rs"]
pub mod meshes;
#[path = "entries/pictures.rs"]
mod pictures;
#[path = "entries/progress.rs"]
mod progress;
#[path = "entries/volumes.rs"]
mod volumes;

pub use beside::{libraries, noise, spectrum_file};
pub use documents::{animation, numbers, spectra, transforms, xml};
pub use folders::{includes, manifest, set};
pub use meshes::{gltf, mtl, obj, ply, serialized, serialized_shape};
pub use pictures::{bmp, exr, hdr, jpeg, layered, pfm, photometry, png, pnm, tga};
pub use progress::{bake, part};
pub use volumes::{media, vdb, vol};

/// Reads bytes as one kind of file.
pub type Entry = fn(&[u8]);

/// All entries by the names of their fuzz targets and of their folders in the corpus.
pub const ENTRIES: [(&str, Entry); 33] = [
    ("xml", xml),
    ("dialect", xml),
    ("animation", |bytes| _ = animation(bytes)),
    ("numbers", numbers),
    ("spectra", spectra),
    ("transforms", transforms),
    ("obj", obj),
    ("mtl", mtl),
    ("ply", ply),
    ("serialized", serialized),
    ("serialized_shape", serialized_shape),
    ("gltf", gltf),
    ("png", png),
    ("jpeg", jpeg),
    ("bmp", bmp),
    ("tga", tga),
    ("pnm", pnm),
    ("hdr", hdr),
    ("exr", exr),
    ("layered", |bytes| _ = layered(bytes)),
    ("pfm", pfm),
    ("photometry", photometry),
    ("vdb", vdb),
    ("vol", vol),
    ("media", |bytes| _ = media(bytes)),
    ("bake", |bytes| _ = bake(bytes)),
    ("part", |bytes| _ = part(bytes)),
    ("libraries", libraries),
    ("spectrum_file", spectrum_file),
    ("noise", noise),
    ("includes", |bytes| _ = includes(bytes)),
    ("set", |bytes| _ = set(bytes)),
    ("manifest", |bytes| _ = manifest(bytes)),
];

/// No file has this name, and none has a name relative to its folder.
const NOWHERE: &str = "/nowhere/scene.xml";

/// The bytes with the first ones replaced, so that they are read as the format that begins so.
fn beginning_with(magic: &[u8], bytes: &[u8]) -> Vec<u8> {
    let mut file = bytes.to_vec();
    file.resize(file.len().max(magic.len()), 0);
    file[..magic.len()].copy_from_slice(magic);
    file
}

/// The CRC-32 of PNG files and of checkpoints.
fn crc(bytes: &[u8]) -> u32 {
    let mut sum = flate2::Crc::new();
    sum.update(bytes);
    sum.sum()
}
