//! The text header of a PLY file: the elements of the body in order, with their properties (Turk, "The PLY polygon file
//! format", 1994).

use super::mesh_file::{MeshError, Place, excerpt};

/// The encoding of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The number types of PLY, under both their old names (`uchar`) and the sized ones (`uint8`), and Mitsuba's 64-bit
/// integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"long" | b"int64" => Self::I64,
            b"ulong" | b"uint64" => Self::U64,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number in a binary body.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at the beginning of a binary record's bytes; 0 if there are too few bytes.
    #[inline]
    pub fn number(self, bytes: &[u8], big_endian: bool) -> f64 {
        macro_rules! read {
            ($number:ty) => {{
                let bytes = bytes.first_chunk().copied().unwrap_or_default();
                if big_endian {
                    <$number>::from_be_bytes(bytes) as f64
                } else {
                    <$number>::from_le_bytes(bytes) as f64
                }
            }};
        }
        match self {
            Self::I8 => read!(i8),
            Self::U8 => read!(u8),
            Self::I16 => read!(i16),
            Self::U16 => read!(u16),
            Self::I32 => read!(i32),
            Self::U32 => read!(u32),
            Self::I64 => read!(i64),
            Self::U64 => read!(u64),
            Self::F32 => read!(f32),
            Self::F64 => read!(f64),
        }
    }

    /// The largest value of an integer type; None for floats.
    pub fn largest_whole(self) -> Option<f64> {
        Some(match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::I64 => i64::MAX as f64,
            Self::U64 => u64::MAX as f64,
            Self::F32 | Self::F64 => return None,
        })
    }

    pub fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    pub name: String,
    /// The number of elements that the header declares. The body may have fewer.
    pub count: u64,
    pub properties: Vec<Property>,
    /// The line of the header that declares the element.
    pub line: u64,
}

impl Element {
    /// Whether there is a property of this name.
    pub fn has(&self, property: &str) -> bool {
        self.properties.iter().any(|p| p.name == property)
    }

    /// The fewest bytes of a record in the body; zero only without properties.
    pub(crate) fn smallest_record(&self, format: Format) -> u64 {
        let sizes = self.properties.iter().map(|property| match (format, property.kind) {
            // A digit and a separator.
            (Format::Ascii, _) => 2,
            (_, Kind::Scalar(scalar)) => scalar.size() as u64,
            (_, Kind::List { count, .. }) => count.size() as u64,
        });
        sizes.sum()
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
    /// The number of lines of the header.
    pub lines: u64,
    /// The offset of the body.
    pub length: usize,
}

pub fn parse_header(bytes: &[u8]) -> Result<Header, MeshError> {
    let mut lines = HeaderLines {
        bytes,
        offset: 0,
        line: 0,
    };
    let magic = lines.next()?;
    if magic != b"ply" {
        return Err(MeshError::syntax(
            Place::Line(1),
            "`ply` as the first line of a PLY file",
            excerpt(magic),
        ));
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let text = lines.next()?;
        let place = Place::Line(lines.line);
        let words: Vec<&[u8]> = text
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, _version] if format.is_none() => {
                format = Some(match name {
                    b"ascii" => Format::Ascii,
                    b"binary_little_endian" => Format::LittleEndian,
                    b"binary_big_endian" => Format::BigEndian,
                    _ => {
                        let expected = "the format `ascii`, `binary_little_endian` or `binary_big_endian`";
                        return Err(MeshError::syntax(place, expected, excerpt(name)));
                    }
                });
            }
            [b"element", name, count] => {
                let Some(count) = parse_count(count) else {
                    return Err(MeshError::syntax(place, "a count of elements", excerpt(count)));
                };
                elements.push(Element {
                    name: name_of(name),
                    count,
                    properties: Vec::new(),
                    line: lines.line,
                });
            }
            [b"property", ref declaration @ ..] => {
                let property = parse_property(declaration, place)?;
                let Some(element) = elements.last_mut() else {
                    return Err(MeshError::syntax(
                        place,
                        "an `element` before its properties",
                        excerpt(text),
                    ));
                };
                element.properties.push(property);
            }
            [b"end_header"] => break,
            _ => return Err(MeshError::syntax(place, "a statement of a PLY header", excerpt(text))),
        }
    }
    let Some(format) = format else {
        let place = Place::Line(lines.line);
        return Err(MeshError::syntax(place, "a `format` in the header", "`end_header`"));
    };
    Ok(Header {
        format,
        elements,
        lines: lines.line,
        length: lines.offset,
    })
}

fn parse_property(declaration: &[&[u8]], place: Place) -> Result<Property, MeshError> {
    let scalar = |name: &[u8]| {
        Scalar::named(name).ok_or_else(|| MeshError::syntax(place, "a PLY number type such as `float`", excerpt(name)))
    };
    match *declaration {
        [b"list", count, item, name] => {
            let count_type = scalar(count)?;
            if count_type.is_float() {
                return Err(MeshError::syntax(
                    place,
                    "a whole number type as list count",
                    excerpt(count),
                ));
            }
            Ok(Property {
                name: name_of(name),
                kind: Kind::List {
                    count: count_type,
                    item: scalar(item)?,
                },
            })
        }
        [kind, name] if kind != b"list" => Ok(Property {
            name: name_of(name),
            kind: Kind::Scalar(scalar(kind)?),
        }),
        _ => Err(MeshError::syntax(
            place,
            "`property TYPE NAME` or `property list COUNT_TYPE ITEM_TYPE NAME`",
            excerpt(&declaration.join(&b' ')),
        )),
    }
}

fn parse_count(text: &[u8]) -> Option<u64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

fn name_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Lines ending in LF, CR LF or a lone CR. A lone CR ends a line only if it ends the first one too: the first byte of a
/// binary body may happen to be a CR.
struct HeaderLines<'a> {
    bytes: &'a [u8],
    offset: usize,
    line: u64,
}

impl<'a> HeaderLines<'a> {
    /// The length limit of the header, in bytes.
    const LONGEST: usize = 1 << 20;

    fn next(&mut self) -> Result<&'a [u8], MeshError> {
        self.line += 1;
        let ends_in_lone_cr = self.bytes.get(3) == Some(&b'\r') && self.bytes.get(4) != Some(&b'\n');
        let end = if ends_in_lone_cr { b'\r' } else { b'\n' };
        let rest = &self.bytes[self.offset..self.bytes.len().min(Self::LONGEST)];
        let Some(length) = rest.iter().position(|&byte| byte == end) else {
            let place = Place::Line(self.line);
            return Err(if self.line == 1 {
                MeshError::syntax(place, "`ply` as the first line of a PLY file", excerpt(rest))
            } else {
                MeshError::Truncated {
                    place,
                    promised: "the header has no `end_header`".into(),
                }
            });
        };
        self.offset += length + 1;
        Ok(rest[..length].trim_ascii())
    }
}
