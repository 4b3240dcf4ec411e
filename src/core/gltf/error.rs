//! The errors of reading glTF files, and the function by which files are read.

use std::fmt;

use crate::memory::Shortage;

/// Reads a file by its name, relative to the glTF file.
pub type ReadFile<'a> = dyn FnMut(&str) -> std::io::Result<Vec<u8>> + 'a;

/// The names of missing files, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingParts {
    /// The files of buffers, without which the file cannot be opened.
    pub buffers: Vec<String>,
    /// The files of images.
    pub images: Vec<String>,
}

impl fmt::Display for MissingParts {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let all = [self.buffers.as_slice(), &self.images].concat();
        write!(out, "{}: no such file", all.join(", "))
    }
}

/// The reason why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum GltfError {
    #[error("{0}")]
    Container(&'static str),
    #[error("{0}")]
    Json(serde_json::Error),
    #[error("glTF version `{0}` is not supported, only 2.0 is")]
    Version(String),
    #[error("the file requires the extension {0}, which is not supported")]
    Extension(String),
    /// An index out of range.
    #[error("{what} {index} is not there: the file has {count}")]
    Index {
        what: &'static str,
        index: usize,
        count: usize,
    },
    #[error("accessor {index} {what}")]
    Accessor { index: usize, what: String },
    #[error("buffer view {index} reaches beyond its buffer")]
    View { index: usize },
    /// A compressed buffer view.
    #[error("buffer view {index} {what}")]
    Unpack { index: usize, what: String },
    #[error("buffer {index} has {held} bytes where {promised} are promised")]
    Buffer { index: usize, held: usize, promised: usize },
    /// The file of a buffer does not have the checksum that was written with the glTF file.
    #[error(
        "the file of buffer {index} is not the one that was written with this file: export the scene again, or copy all of its files"
    )]
    OtherBuffer { index: usize },
    #[error("primitive {index}: {what}")]
    Primitive { index: usize, what: String },
    #[error("node {0} is its own ancestor, or the child of two nodes")]
    Tree(usize),
    /// A sampler of an animation.
    #[error("sampler {index} {what}")]
    Sampler { index: usize, what: String },
    /// The limit on computed node poses for key frames was reached.
    #[error("the animations need more than {0} poses of nodes, which are too many")]
    Poses(usize),
    #[error("image {index}: {what}")]
    Image { index: usize, what: String },
    #[error("light profile {index}: {what}")]
    Profile { index: usize, what: String },
    /// A number is out of the range of the scene format.
    #[error("`{name}` of {owner} is too large for a number of single precision")]
    Number { name: String, owner: String },
    /// The largest coordinate of the scene, and the largest for which a camera can be placed.
    #[error("the scene has no camera, and reaches to {reach:e}: a camera is placed only up to {limit:e}")]
    Reach { reach: f32, limit: f32 },
    #[error("the URI `{uri}` {what}")]
    Uri { uri: String, what: &'static str },
    #[error("the objects of the file need {0}")]
    Objects(Shortage),
    #[error("the buffers and meshes need {0}")]
    Memory(Shortage),
    #[error("{name}: {source}")]
    File { name: String, source: std::io::Error },
    #[error("{0}")]
    Missing(MissingParts),
    /// A file made of a part of the glTF file cannot be written.
    #[error("{name} cannot be kept: {source}")]
    Keep { name: String, source: std::io::Error },
}
