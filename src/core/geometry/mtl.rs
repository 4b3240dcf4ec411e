//! Reads MTL material libraries, the companions of OBJ files, and interprets their materials.
//!
//! The `tobj` crate parses the statements that it knows. It gets them one by one: in a whole library it stops at the
//! first statement that it does not understand, without saying where. Such a statement is a warning here.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use glam::Vec3;

use super::mesh::MtlMaterial;
use super::mesh_file::{Place, Warnings, decode, excerpt};
use super::mtl_map::{MtlMaps, parse_map};

/// The most materials of a library that are read: triangles index them with sixteen bits.
const MOST_MATERIALS: usize = 1 << 16;

/// The material of triangles whose `usemtl` names no existing one: the grey that Mitsuba gives shapes without a bsdf.
pub(super) fn default_material(name: &str) -> MtlMaterial {
    MtlMaterial {
        name: name.to_owned(),
        kd: Vec3::splat(0.5),
        ks: Vec3::ZERO,
        ke: Vec3::ZERO,
        ns: 1.0,
        ni: 1.5,
        d: 1.0,
        tf: Vec3::ONE,
        illum: None,
        pr: None,
        pm: None,
        maps: MtlMaps::default(),
    }
}

/// The materials of one library, in the order of the file. `library` is its name in warnings.
///
/// Texture paths are relative to the folder of the mesh. Absent values: Ks, Ke black; Kd black if the material has
/// another colour, otherwise 0.5; Ns 1; Ni 1.5; d 1; Tf white.
fn read_mtl(bytes: &[u8], library: &str, warnings: &mut Warnings) -> Vec<MtlMaterial> {
    let library_name = library.replace('\\', "/");
    let folder = Path::new(&library_name).parent().unwrap_or(Path::new(""));
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let mut given = Given::default();
    let mut has_material = false;
    for (number, line) in (1u64..).zip(decode(bytes).trim_start_matches('\u{feff}').lines()) {
        let mut warn = |message: &str| warnings.add(format_args!("{library} line {number}"), message);
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword == "newmtl" {
            has_material = !rest.trim().is_empty();
            if has_material && materials.len() == MOST_MATERIALS {
                warn("further materials are ignored");
                break;
            }
            match has_material {
                true => materials.push(default_material(rest.trim())),
                false => warn("a material without a name is ignored"),
            }
            given = Given::default();
            continue;
        }
        let Some(material) = materials.last_mut().filter(|_| has_material) else {
            continue;
        };
        if is_texture(keyword) {
            match (material.maps.slot(keyword), parse_map(rest, folder)) {
                (Some(slot), Some(map)) => *slot = Some(map),
                _ => warn(&format!("the texture statement `{keyword}` is ignored")),
            }
            continue;
        }
        let values = rest.split_whitespace().take_while(|word| !word.starts_with('#'));
        if read_statement(material, &mut given, keyword, &values.collect::<Vec<_>>()).is_none() {
            warn(&format!("{} is not understood and ignored", excerpt(line.as_bytes())));
        }
    }
    for material in &materials {
        warn_of_oddities(material, library, warnings);
    }
    materials
}

/// Warns of values that are probably mistakes, and of values that are ignored.
fn warn_of_oddities(material: &MtlMaterial, library: &str, warnings: &mut Warnings) {
    let name = excerpt(material.name.as_bytes());
    let of_material = format!("{library} material {name}");
    if material.d == 0.0 && material.maps.d.is_none() && !matches!(material.model(), MtlModel::Glass { .. }) {
        warnings.add(
            &of_material,
            "its opacity (`d`, or 1 - `Tr`) is 0, so that it is invisible",
        );
    }
    if material.maps.ke.is_some() && material.ke != Vec3::ZERO && material.ke != Vec3::ONE {
        warnings.add(
            &of_material,
            "`map_Ke` takes the place of `Ke`, which is not multiplied with it",
        );
    }
}

/// The statements that a material has of those that take precedence over others.
#[derive(Default)]
struct Given {
    kd: bool,
    d: bool,
}

/// Applies a statement that is no texture. None if it makes no sense.
fn read_statement(material: &mut MtlMaterial, given: &mut Given, keyword: &str, values: &[&str]) -> Option<()> {
    let halo = values.strip_prefix(&["-halo"]).filter(|_| keyword == "d");
    let values = halo.unwrap_or(values);
    let read = || read_by_tobj(keyword, values);
    let number = |least: f32, most: f32| within(values.first()?.parse().ok(), least, most);
    match keyword {
        "Kd" => material.kd = color(read()?.diffuse)?,
        "Ks" => material.ks = color(read()?.specular)?,
        "Ke" => material.ke = color(read()?.emissive)?,
        "Ns" => material.ns = within(read()?.shininess, 0.0, f32::MAX)?,
        "Ni" => material.ni = within(read()?.optical_density, f32::MIN_POSITIVE, f32::MAX)?,
        "d" => material.d = within(read()?.dissolve, 0.0, 1.0)?,
        // The crate knows none of these, and no `illum 2.0`. `Tr` is the complement of `d`, and older.
        "Tr" if given.d => _ = number(0.0, 1.0)?,
        "Tr" => material.d = 1.0 - number(0.0, 1.0)?,
        "Tf" => material.tf = filter(values)?,
        "Pr" => material.pr = Some(number(0.0, 1.0)?),
        "Pm" => material.pm = Some(number(0.0, 1.0)?),
        "illum" => material.illum = Some(number(0.0, 10.0)? as u8),
        // Ambient light and similar values have no meaning for a path tracer.
        _ => {}
    }
    given.kd |= keyword == "Kd";
    given.d |= keyword == "d";
    if matches!(keyword, "Ks" | "Ke") && !given.kd {
        material.kd = Vec3::ZERO;
    }
    Some(())
}

/// Parses one statement into a new material.
fn read_by_tobj(keyword: &str, values: &[&str]) -> Option<tobj::Material> {
    let values = match keyword.starts_with('K') {
        // The crate panics at colours of fewer numbers.
        true => three(values)?.join(" "),
        false => values.join(" "),
    };
    let text = format!("newmtl _\n{keyword} {values}");
    let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).ok()?;
    materials.into_iter().next()
}

fn is_texture(keyword: &str) -> bool {
    let keyword = keyword.to_ascii_lowercase();
    keyword.starts_with("map_") || matches!(keyword.as_str(), "bump" | "norm" | "disp" | "decal" | "refl")
}

/// The numbers of a colour. One number stands for three equal ones. Spectral files and XYZ are not read.
fn three<'a>(values: &[&'a str]) -> Option<[&'a str; 3]> {
    match *values {
        [grey] => Some([grey; 3]),
        [r, g, b, ..] => Some([r, g, b]),
        _ => None,
    }
}

/// A colour that is not negative.
fn color(channels: Option<[f32; 3]>) -> Option<Vec3> {
    let color = Vec3::from(channels?);
    (color.is_finite() && color.min_element() >= 0.0).then_some(color)
}

/// A transmission filter, a colour that is at most white.
fn filter(values: &[&str]) -> Option<Vec3> {
    let [r, g, b] = three(values)?.map(|value| value.parse().ok());
    color(Some([r?, g?, b?])).filter(|color| color.max_element() <= 1.0)
}

fn within(value: Option<f32>, least: f32, most: f32) -> Option<f32> {
    value.filter(|value| (least..=most).contains(value))
}

/// The largest diffuse colour that counts as black: some exporters avoid zero.
const AS_GOOD_AS_BLACK: f32 = 0.02;

/// The kinds of surfaces that MTL materials stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MtlModel {
    /// Clear glass with the transmission colour `tf`.
    Glass {
        /// The index of refraction.
        index: f32,
    },
    /// Rough metal with the colour `kd`.
    Metal {
        /// The roughness as the file gives it, the square root of the width of the microfacet distribution; use at
        /// least [`MtlModel::LEAST_ROUGHNESS`].
        roughness: f32,
    },
    /// A mirror with the colour `ks`.
    Mirror,
    /// Diffuse `kd`.
    Matt,
}

impl MtlModel {
    /// The least roughness of a metal.
    pub const LEAST_ROUGHNESS: f32 = 0.03;
}

impl MtlMaterial {
    /// The kind of surface. MTL describes Phong-like shading, so this is an interpretation. Surfaces other than glass
    /// have the opacity [`MtlMaterial::d`].
    pub fn model(&self) -> MtlModel {
        let refracts = (self.ni - 1.0).abs() > 1e-3 && self.ni > 0.0;
        if matches!(self.illum, Some(6 | 7)) || refracts && matches!(self.illum, Some(4 | 9)) {
            let index = if refracts { self.ni } else { 1.5 };
            return MtlModel::Glass { index };
        }
        if self.pm.is_some_and(|metallic| metallic > 0.5) {
            let roughness = self.pr.unwrap_or(0.0);
            return MtlModel::Metal { roughness };
        }
        match self.illum {
            Some(3 | 5) if self.kd.max_element() <= AS_GOOD_AS_BLACK => MtlModel::Mirror,
            _ => MtlModel::Matt,
        }
    }
}

/// The most libraries that are searched, more than any real file names.
const MOST_LIBRARIES: usize = 64;

/// The material libraries of a file while its statements are read.
pub(super) struct Libraries<'l> {
    fetch: &'l mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
    /// The names of libraries requested so far. Each is requested only once.
    asked: HashSet<String>,
    /// The materials so far, in the order of the statements.
    pub materials: Vec<MtlMaterial>,
}

impl<'l> Libraries<'l> {
    /// `fetch` returns the content of the library with a name.
    pub fn new(fetch: &'l mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Self {
        Self {
            fetch,
            asked: HashSet::new(),
            materials: Vec::new(),
        }
    }

    /// Reads the library or libraries of a statement: `names` is one file name, spaces included, or if there is no such
    /// file, several names.
    pub fn add(&mut self, names: &str, place: Place, warnings: &mut Warnings) {
        let whole = names.trim_matches('"');
        let Err(error) = self.read(whole, place, warnings) else {
            return;
        };
        let several = names.split_whitespace().take(MOST_LIBRARIES);
        if several.clone().count() < 2 {
            warnings.add(place, &unreadable(whole, &error));
            return;
        }
        for name in several {
            if let Err(error) = self.read(name, place, warnings) {
                warnings.add(place, &unreadable(name, &error));
            }
        }
    }

    /// Reads one library, unless it was requested before.
    fn read(&mut self, name: &str, place: Place, warnings: &mut Warnings) -> io::Result<()> {
        if self.asked.contains(name) {
            return Ok(());
        }
        if self.asked.len() == MOST_LIBRARIES || self.materials.len() >= MOST_MATERIALS {
            warnings.add(place, "further material libraries are ignored");
            return Ok(());
        }
        self.asked.insert(name.to_owned());
        let bytes = (self.fetch)(name)?;
        self.materials.extend(read_mtl(&bytes, name, warnings));
        Ok(())
    }
}

fn unreadable(name: &str, error: &io::Error) -> String {
    let name = excerpt(name.as_bytes());
    format!("the material library {name} cannot be read: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> (Vec<MtlMaterial>, Vec<String>) {
        let mut warnings = Warnings::default();
        let materials = read_mtl(text, "a.mtl", &mut warnings);
        (materials, warnings.finish())
    }

    #[test]
    fn every_value_arrives() {
        let (materials, warnings) = read(
            b"# one\nnewmtl red wall \r\nKa 1 1 1\n\tKd .5 0.25 1e-1 # inline\nKs 1 2 3\nKe 4 5 6\nNs 10\nNi 1.33\nd 0.75\nTr 0.5\nTf .9 0.5 0\nillum 2\nPr 0.3\nPm 1\n",
        );
        assert_eq!(warnings, [""; 0]);
        let expected = MtlMaterial {
            name: "red wall".into(),
            kd: Vec3::new(0.5, 0.25, 0.1),
            ks: Vec3::new(1.0, 2.0, 3.0),
            ke: Vec3::new(4.0, 5.0, 6.0),
            ns: 10.0,
            ni: 1.33,
            d: 0.75,
            tf: Vec3::new(0.9, 0.5, 0.0),
            illum: Some(2),
            pr: Some(0.3),
            pm: Some(1.0),
            maps: MtlMaps::default(),
        };
        assert_eq!(materials, [expected]);
    }

    #[test]
    fn absent_values_have_defaults() {
        let (materials, _) = read(b"newmtl a\nnewmtl b\nTr 0.25\nKs 1 1 1\nnewmtl c\nKe 1 1 1\n");
        assert_eq!(materials[0], default_material("a"));
        assert_eq!((materials[1].d, materials[1].kd), (0.75, Vec3::ZERO));
        assert_eq!(materials[2].kd, Vec3::ZERO);
    }

    #[test]
    fn bad_statements_are_warnings_and_the_rest_is_kept() {
        let (materials, warnings) = read(
            b"Kd 1 0 0\nnewmtl\nKd 1 0 0\nnewmtl a\nKd 0.5\nKs 1 2\nKe nan 0 0\nNs -1\nNi 0\nd 7\nillum many\nmap_Ks -s 1 a.png\nmap_Ks b.png\nmap_Kd -clamp on\nKd spectral x.rfl\nTf 1.5\nTf xyz 1 1 1\n\xff\xfe\n",
        );
        assert_eq!(
            materials,
            [MtlMaterial {
                kd: Vec3::splat(0.5),
                ..default_material("a")
            }]
        );
        assert_eq!(
            warnings,
            [
                "a.mtl line 2: a material without a name is ignored",
                "a.mtl line 6: `Ks 1 2` is not understood and ignored",
                "a.mtl line 7: `Ke nan 0 0` is not understood and ignored",
                "a.mtl line 8: `Ns -1` is not understood and ignored",
                "a.mtl line 9: `Ni 0` is not understood and ignored",
                "a.mtl line 10: `d 7` is not understood and ignored",
                "a.mtl line 11: `illum many` is not understood and ignored",
                "a.mtl line 12: the texture statement `map_Ks` is ignored (and 1 times more)",
                "a.mtl line 14: the texture statement `map_Kd` is ignored",
                "a.mtl line 15: `Kd spectral x.rfl` is not understood and ignored",
                "a.mtl line 16: `Tf 1.5` is not understood and ignored",
                "a.mtl line 17: `Tf xyz 1 1 1` is not understood and ignored",
            ]
        );
    }

    #[test]
    fn pictures_are_named_from_the_folder_of_the_mesh() {
        let text = b"newmtl a\nnewmtl b\nmap_Kd -s 2 wood 1.png\nmap_D h.png\nnewmtl c\nnorm n.png\n";
        let materials = read_mtl(text, "lib/b.mtl", &mut Warnings::default());
        assert_eq!(materials[0].maps, MtlMaps::default());
        let kd = materials[1].maps.kd.as_ref().unwrap();
        assert_eq!((&*kd.file, kd.scale.x), (Path::new("lib/wood 1.png"), 2.0));
        assert_eq!(materials[1].maps.d.as_ref().unwrap().file, Path::new("lib/h.png"));
        assert_eq!(materials[2].maps.norm.as_ref().unwrap().file, Path::new("lib/n.png"));
    }

    #[test]
    fn names_in_other_encodings_are_kept_apart() {
        let (materials, _) = read(b"newmtl Terraind\xe6k\nKd 1 1 1\n");
        assert_eq!(materials[0].name, "Terraind\u{e6}k");
    }
}
