//! Parses texture statements of MTL: `map_Kd -s 2 2 2 -o 0.5 0 -clamp on wood floor.png`.

use std::path::{Path, PathBuf};

use glam::Vec2;

/// A texture over the mesh's own uv, as a library names it.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMap {
    /// The path relative to the folder of the mesh; it begins with the path to the library's folder.
    pub file: PathBuf,
    /// The scale: the texture is looked up at uv times `scale` plus `offset`; v counts from the bottom up, as in OBJ.
    pub scale: Vec2,
    /// The offset, see `scale`.
    pub offset: Vec2,
    /// Whether the texture is clamped to its edge outside of the unit square, instead of repeated.
    pub clamp: bool,
    /// The factor of heights, `-bm`; 1 by default.
    pub bump: f32,
}

/// The textures of a material; each replaces the value of the same name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaps {
    /// The map of the diffuse colour.
    pub kd: Option<MtlMap>,
    /// The map of the emitted radiance.
    pub ke: Option<MtlMap>,
    /// The map of the opacity.
    pub d: Option<MtlMap>,
    /// The height map; [`MtlMap::bump`] scales it to units of the mesh.
    pub bump: Option<MtlMap>,
    /// The normal map in tangent space.
    pub norm: Option<MtlMap>,
}

impl MtlMaps {
    /// The field for `keyword`, ignoring case; None for an unsupported texture.
    pub(super) fn slot(&mut self, keyword: &str) -> Option<&mut Option<MtlMap>> {
        Some(match &*keyword.to_ascii_lowercase() {
            "map_kd" => &mut self.kd,
            "map_ke" => &mut self.ke,
            "map_d" => &mut self.d,
            "bump" | "map_bump" => &mut self.bump,
            "norm" | "map_norm" => &mut self.norm,
            _ => return None,
        })
    }

    /// The textures that are given.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut MtlMap> {
        let Self { kd, ke, d, bump, norm } = self;
        [kd, ke, d, bump, norm].into_iter().flatten()
    }

    /// The textures that are given.
    pub fn iter(&self) -> impl Iterator<Item = &MtlMap> {
        let Self { kd, ke, d, bump, norm } = self;
        [kd, ke, d, bump, norm].into_iter().flatten()
    }
}

/// Parses the text after the keyword: options, then a file name in `folder`, which may have blanks. None without a
/// name.
pub(super) fn parse_map(text: &str, folder: &Path) -> Option<MtlMap> {
    let mut map = MtlMap {
        file: PathBuf::new(),
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
        clamp: false,
        bump: 1.0,
    };
    let mut rest = text.trim();
    while let Some((option, after)) = rest.split_once(char::is_whitespace).filter(|_| rest.starts_with('-')) {
        // An option takes up to this many numbers, or a word.
        let (numbers, takes_word) = match option {
            "-s" | "-o" | "-t" => (3, false),
            "-mm" => (2, false),
            "-bm" | "-boost" | "-texres" => (1, false),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" | "-colorspace" => (0, true),
            // A file name that begins with a minus.
            _ => break,
        };
        let mut values = [None; 3];
        let mut word = "";
        rest = after.trim_start();
        for value in values.iter_mut().take(numbers) {
            let (first, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            let Some(number) = first.parse().ok().filter(|number: &f32| number.is_finite()) else {
                break;
            };
            *value = Some(number);
            rest = behind.trim_start();
        }
        if takes_word {
            let behind;
            (word, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            rest = behind.trim_start();
        }
        let pair = |absent: Vec2| Vec2::new(values[0].unwrap_or(absent.x), values[1].unwrap_or(absent.y));
        match option {
            "-s" => map.scale = pair(Vec2::ONE),
            "-o" => map.offset = pair(Vec2::ZERO),
            "-clamp" => map.clamp = word == "on",
            "-bm" => map.bump = values[0].unwrap_or(1.0),
            _ => {}
        }
    }
    // Libraries made on Windows have quotes and backslashes.
    let name = rest.trim_matches('"').replace('\\', "/");
    map.file = folder.join(&name);
    (!name.is_empty()).then_some(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_names_with_blanks() {
        let parse_map = |text: &str| super::parse_map(text, Path::new(""));
        let parse = |text: &str| parse_map(text).unwrap();
        assert_eq!(parse("a b.png").file, PathBuf::from("a b.png"));
        assert_eq!(parse("  \"tex\\a.png\" ").file, PathBuf::from("tex/a.png"));
        let map = parse("-s 2 3 4 -o 0.5 -clamp on -bm 0.25 -colorspace sRGB wood 01.png");
        assert_eq!((map.scale, map.offset), (Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0)));
        assert!(map.clamp);
        assert_eq!(map.bump, 0.25);
        assert_eq!(map.file, PathBuf::from("wood 01.png"));
        // The third word is no number, so only two are the scale.
        let map = parse("-s 0.1 0.2 specular.jpg");
        assert_eq!(
            (map.scale, map.file),
            (Vec2::new(0.1, 0.2), PathBuf::from("specular.jpg"))
        );
        assert_eq!(parse("-mm 0 1 -imfchan l -odd.png").file, PathBuf::from("-odd.png"));
        for text in ["", " ", "-s 1 1 1", "-clamp on", "\"\""] {
            assert_eq!(parse_map(text), None, "{text}");
        }
    }
}
