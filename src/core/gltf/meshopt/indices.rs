//! The codecs of indices: of triangles, whose corners are found among recent edges and vertices, and of any others.

use super::stream::{Fault, HEADER, Reader, SHORT, difference};

/// The sixteen latest entries.
struct Recent<T> {
    entries: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self {
            entries: [T::default(); 16],
            pushed: 0,
        }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.pushed % 16] = entry;
        self.pushed += 1;
    }

    /// The entry that was pushed this many entries before the latest one, less than 16.
    fn get(&self, age: u8) -> Result<T, Fault> {
        let place = self.pushed.checked_sub(1 + usize::from(age));
        let place = place.ok_or("its compressed triangles name one that is not there")?;
        Ok(self.entries[place % 16])
    }
}

/// The state of a decoder of triangles.
struct Decoder<'a> {
    data: Reader<'a>,
    /// The next vertex that no triangle had so far.
    next: u32,
    /// The last vertex that was given by its number.
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

/// The indices of triangles; `count` is that of the indices.
pub fn triangles(stream: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    /// The bytes of the table at the end.
    const TABLE: usize = 16;
    if !count.is_multiple_of(3) {
        return Err("its compressed triangles have no whole number");
    }
    let mut reader = Reader(stream);
    if reader.byte()? != 0xe1 {
        return Err(HEADER);
    }
    // Each triangle takes a byte at least, so that a short stream asks for little memory.
    let codes = reader.take(count / 3)?;
    let data = reader.0.len().checked_sub(TABLE).ok_or(SHORT)?;
    let mut decoder = Decoder {
        data: Reader(reader.take(data)?),
        next: 0,
        last: 0,
        edges: Recent::new(),
        vertices: Recent::new(),
    };
    let table = reader.take(TABLE)?;
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        let triangle = match (code >> 4, code & 15) {
            (15, place @ ..14) => {
                let first = decoder.unseen();
                decoder.triangle_at(first, table[usize::from(place)])?
            }
            (15, place) => decoder.free_triangle(place == 15)?,
            (edge, vertex) => decoder.triangle_on(edge, vertex)?,
        };
        indices.extend(triangle);
    }
    decoder.data.finish()?;
    Ok(indices)
}

impl Decoder<'_> {
    fn unseen(&mut self) -> u32 {
        let next = self.next;
        self.next = next.wrapping_add(1);
        next
    }

    /// A vertex that is given by its number.
    fn given(&mut self) -> Result<u32, Fault> {
        self.last = self.last.wrapping_add(difference(self.data.number()?));
        Ok(self.last)
    }

    /// A triangle on a recent edge.
    fn triangle_on(&mut self, edge: u8, vertex: u8) -> Result<[u32; 3], Fault> {
        let [a, b] = self.edges.get(edge)?;
        let c = match vertex {
            0 => self.unseen(),
            1..=12 => self.vertices.get(vertex)?,
            13 | 14 => {
                let step = if vertex == 13 { u32::MAX } else { 1 };
                self.last = self.last.wrapping_add(step);
                self.last
            }
            _ => self.given()?,
        };
        if !(1..=12).contains(&vertex) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// A triangle without a recent edge, whose kinds of corners are a byte of the data.
    fn free_triangle(&mut self, is_first_given: bool) -> Result<[u32; 3], Fault> {
        let kinds = self.data.byte()?;
        if kinds == 0 {
            self.next = 0;
        }
        let first = match is_first_given {
            true => self.given()?,
            false => self.unseen(),
        };
        self.triangle_at(first, kinds)
    }

    /// A triangle with a first corner. `kinds` says, in four bits each, what the other corners are: unseen, a recent
    /// vertex, or given by their numbers.
    fn triangle_at(&mut self, a: u32, kinds: u8) -> Result<[u32; 3], Fault> {
        let mut corner = |kind: u8| match kind {
            0 => Ok(self.unseen()),
            15 => self.given(),
            _ => self.vertices.get(kind - 1),
        };
        let kinds = [kinds >> 4, kinds & 15];
        let [b, c] = [corner(kinds[0])?, corner(kinds[1])?];
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        self.vertices.push(a);
        for (kind, vertex) in kinds.into_iter().zip([b, c]) {
            if matches!(kind, 0 | 15) {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// Indices in any order.
pub fn sequence(stream: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    /// The bytes of padding at the end.
    const TAIL: usize = 4;
    let mut reader = Reader(stream);
    if reader.byte()? != 0xd1 {
        return Err(HEADER);
    }
    let data = reader
        .0
        .len()
        .checked_sub(TAIL)
        .filter(|data| *data >= count)
        .ok_or(SHORT)?;
    let mut reader = Reader(reader.take(data)?);
    // Two sequences may alternate.
    let mut last = [0u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let number = reader.number()?;
        let last = &mut last[(number & 1) as usize];
        *last = last.wrapping_add(difference(number >> 1));
        indices.push(*last);
    }
    reader.finish()?;
    Ok(indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_follow_from_edges_and_vertices() {
        let table = [0; 16];
        // Three unseen vertices; the edge (0, 2) and an unseen one; the edge (0, 3) and the second latest vertex; three
        // that are given by their numbers.
        let codes = [0xf0, 0x00, 0x01, 0xff];
        let data = [0xff, 20, 2, 1];
        let stream = [&[0xe1], &codes[..], &data, &table].concat();
        let expected = [[0, 1, 2], [0, 2, 3], [0, 3, 2], [10, 11, 10]];
        assert_eq!(triangles(&stream, 12), Ok(expected.concat()));
        assert!(triangles(&stream[..stream.len() - 1], 12).is_err());
        let too_long = [&[0xe1], &codes[..], &data, &[0], &table].concat();
        assert_eq!(triangles(&too_long, 12), Err(super::super::stream::LONG));
        let without_edge = [&[0xe1, 0x00], &table[..]].concat();
        assert!(triangles(&without_edge, 3).is_err());
        assert_eq!(triangles(&stream, 3 << 40), Err(SHORT));
    }

    #[test]
    fn two_sequences_alternate() {
        // 3 and 4 on the first, 100 and 99 on the second.
        let stream = [0xd1, 12, 0x91, 0x03, 4, 3, 0, 0, 0, 0];
        assert_eq!(sequence(&stream, 4), Ok(vec![3, 100, 4, 99]));
        assert_eq!(sequence(&stream, 5), Err(SHORT));
        assert_eq!(sequence(&stream, usize::MAX), Err(SHORT));
    }
}
