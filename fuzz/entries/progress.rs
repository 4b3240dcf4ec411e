//! Checkpoints and shares of pictures and of bakes.

use std::io::{Cursor, Write as _};
use std::path::Path;
use std::sync::LazyLock;

use rayon::{ThreadPool, ThreadPoolBuilder};
use sunroom_core::bake::part::{decode as decode_part, read_part as read_bake, write_part as write_bake};
use sunroom_core::render::bytes::Writer;
use sunroom_core::render::film::Film;
use sunroom_core::render::part::{PartFile, PartHeader, write_part};
use sunroom_core::render::tile::Tile;

use super::{beginning_with, crc};

/// A checkpoint or share of a bake, with the checksum that it should have: hardly any mutation would get past it. What
/// is read is the same after it was written and read again, and pictures without a number that is not finite are made
/// of it. Returns whether they were.
pub fn bake(bytes: &[u8]) -> bool {
    static POOL: LazyLock<ThreadPool> =
        LazyLock::new(|| ThreadPoolBuilder::new().num_threads(1).build().expect("a thread"));
    const MARK: &[u8; 8] = b"SUNBAKE\n";
    let bytes = bytes.strip_prefix(MARK).unwrap_or(bytes);
    let state = beginning_with(
        b"\x06\0\0\0",
        bytes.split_last_chunk::<TAIL>().map_or(bytes, |(state, _)| state),
    );
    let file = with_state(MARK, &state);
    let part = match decode_part(&mut Cursor::new(&file.0)) {
        Ok(part) => part,
        Err(error) => {
            let _ = error.to_string();
            return false;
        }
    };
    let (header, blueprint, light) = &part;
    let file = tempfile::NamedTempFile::new().expect("a temporary folder");
    let written = write_bake(file.path(), header, blueprint.as_ref(), &light.lights, &light.spent);
    assert!(written.is_ok() && read_bake(file.path()).is_ok_and(|again| again == part));
    let (_, Some(mut blueprint), light) = part else {
        return false;
    };
    let size = blueprint.places.size;
    let texels: usize = light.lights.iter().map(|light| light.texel_count()).sum();
    if u64::from(size.x) * u64::from(size.y) * blueprint.page_count() as u64 > 1 << 14 || texels > 1 << 12 {
        return false;
    }
    blueprint.denoise = false;
    let baked = blueprint.finished(&light.lights, &POOL).expect("nothing is denoised");
    assert_eq!(baked.lightmaps.len(), blueprint.page_count());
    let mut pixels = baked.lightmaps.iter().flat_map(|lightmap| &lightmap.irradiance);
    assert!(pixels.all(|pixel| pixel.is_finite()));
    true
}

/// A checkpoint or share of a picture, without the picture in front, and with the checksum and the length that it
/// should have. What is read is the same after it was written and read again. Returns whether it was written.
pub fn part(bytes: &[u8]) -> bool {
    const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let state = with_state(&EXR, bytes);
    let file = tempfile::NamedTempFile::new().expect("a temporary folder");
    file.as_file().write_all(&state.0).expect("a temporary folder");
    let Some((header, film, job)) = read_part(file.path()) else {
        return false;
    };
    // Sums of finite sums may be beyond all numbers, and such a file is refused.
    let vectors = [film.radiance(), film.albedo(), film.normal()].concat();
    if !vectors.iter().all(|vector| vector.is_finite()) || !film.depth().iter().all(|depth| depth.is_finite()) {
        return false;
    }
    let tiles: Vec<Tile> = header.crop.tiles(header.width, header.height).collect();
    write_part(file.path(), &EXR, &header, &film, &tiles, &job).expect("a temporary folder");
    let (header_again, film_again, job_again) = read_part(file.path()).expect("it was written");
    assert_eq!((header_again, job_again), (header, job));
    let content = |film: &Film| {
        let mut content = Writer::default();
        tiles.iter().for_each(|&tile| film.write_tile(tile, &mut content));
        film.write_splats(&mut content);
        content
    };
    assert!(content(&film) == content(&film_again), "the film is another one");
    true
}

/// The checksum, the length and the mark behind a state.
const TAIL: usize = 4 + 8 + 8;

/// A file with a state, and with the checksum and the length that it should have.
fn with_state(front: &[u8], state: &[u8]) -> Writer {
    let mut file = Writer([front, state].concat());
    file.put(crc(state));
    file.put(state.len() as u64);
    file.put(*b"SUNROOM+");
    file
}

/// The header, the film and the job of a part that is small.
fn read_part(path: &Path) -> Option<(PartHeader, Film, Vec<u8>)> {
    let file = match PartFile::open(path) {
        Ok(file) => file,
        Err(error) => {
            let _ = error.to_string();
            return None;
        }
    };
    let (header, kept) = (file.header().clone(), file.header().film_layers());
    if Film::memory_bytes(header.width, header.height, kept) > 4 << 20 {
        return None;
    }
    let mut film = Film::with_layers(header.width, header.height, kept);
    if header.samples[0] > 0 {
        film.keep_chunks();
    }
    let job = file.read_into(&mut film).ok()?;
    Some((header, film, job))
}
