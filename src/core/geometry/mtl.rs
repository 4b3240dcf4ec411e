//! Reads MTL material libraries, the companions of OBJ files.
//!
//! The `tobj` crate reads the statements. It stops the whole library at the first one it does not like (and panics at a
//! colour of one or two numbers, which the format allows), so each line is looked at first: what is sound goes to it in
//! canonical form, the rest is a warning.

use std::fmt::Write as _;
use std::path::Path;

use glam::Vec3;

use super::mesh::MtlMaterial;
use super::mesh_file::{Warnings, decode, excerpt};
use super::mtl_map::{MtlMaps, parse_map};
use super::mtl_model::MtlModel;

/// The most materials of a library that are read: triangles count them with sixteen bits.
pub(super) const MOST_MATERIALS: usize = 1 << 16;

/// The material of triangles whose `usemtl` names none that exists: the grey that Mitsuba gives shapes without a bsdf.
pub fn default_material(name: &str) -> MtlMaterial {
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

/// The materials of one library, in the order of the file. `library` names it in the warnings.
///
/// Pictures are named from the folder of the mesh. Absent values: Ks, Ke black; Kd black if the material has another
/// colour, otherwise 0.5; Ns 1; Ni 1.5; d 1; Tf white.
pub fn read_mtl(bytes: &[u8], library: &str, warnings: &mut Warnings) -> Vec<MtlMaterial> {
    let Statements { text, mut maps } = sound_statements(&decode(bytes), library, warnings);
    let library_name = library.replace('\\', "/");
    let folder = Path::new(&library_name).parent().unwrap_or(Path::new(""));
    for map in maps.iter_mut().flat_map(MtlMaps::iter_mut) {
        map.file = folder.join(&map.file);
    }
    match tobj::load_mtl_buf(&mut text.as_bytes()) {
        Ok((materials, _)) => {
            let materials = materials.iter().zip(maps);
            let materials: Vec<MtlMaterial> = materials.map(|(material, maps)| convert(material, maps)).collect();
            for material in &materials {
                warn_of_oddities(material, library, warnings);
            }
            materials
        }
        Err(error) => {
            warnings.add(library, &format!("the material library is ignored: {error}"));
            Vec::new()
        }
    }
}

/// Warns of what is hardly meant, and of what is not kept.
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

struct Statements {
    /// One per line, every number finite and in range.
    text: String,
    /// The maps of each material.
    maps: Vec<MtlMaps>,
}

/// The statements that make sense.
fn sound_statements(text: &str, library: &str, warnings: &mut Warnings) -> Statements {
    let mut sound = String::with_capacity(text.len());
    let mut all_maps: Vec<MtlMaps> = Vec::new();
    let mut has_material = false;
    for (number, line) in (1u64..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let mut warn = |message: &str| warnings.add(format_args!("{library} line {number}"), message);
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword == "newmtl" {
            has_material = !rest.trim().is_empty();
            if has_material && all_maps.len() == MOST_MATERIALS {
                warn("further materials are ignored");
                break;
            }
            if has_material {
                let _ = writeln!(sound, "newmtl {}", rest.trim());
                all_maps.push(MtlMaps::default());
            } else {
                warn("a material without a name is ignored");
            }
            continue;
        }
        if keyword.is_empty() || keyword.starts_with('#') || !has_material {
            continue;
        }
        if is_texture(keyword) {
            match (all_maps.last_mut().and_then(|maps| maps.slot(keyword)), parse_map(rest)) {
                (Some(slot), Some(map)) => *slot = Some(map),
                _ => warn(&format!("the texture statement `{keyword}` is ignored")),
            }
            continue;
        }
        let values: Vec<&str> = rest
            .split_whitespace()
            .take_while(|word| !word.starts_with('#'))
            .collect();
        let written = match keyword {
            "Kd" | "Ks" | "Ke" => color(&values).map(|[r, g, b]| writeln!(sound, "{keyword} {r} {g} {b}")),
            "Tf" => filter(&values).map(|[r, g, b]| writeln!(sound, "Tf {r} {g} {b}")),
            "Ns" => number_in(&values, 0.0, f32::MAX).map(|value| writeln!(sound, "Ns {value}")),
            "Ni" => number_in(&values, f32::MIN_POSITIVE, f32::MAX).map(|value| writeln!(sound, "Ni {value}")),
            "d" if values.first() == Some(&"-halo") => {
                number_in(&values[1..], 0.0, 1.0).map(|d| writeln!(sound, "d {d}"))
            }
            "d" | "Tr" | "Pr" | "Pm" => number_in(&values, 0.0, 1.0).map(|value| writeln!(sound, "{keyword} {value}")),
            "illum" => number_in(&values, 0.0, 10.0).map(|model| writeln!(sound, "illum {}", model as u8)),
            // Ambient light and the like have no meaning for a path tracer.
            _ => continue,
        };
        if written.is_none() {
            warn(&format!("{} is not understood and ignored", excerpt(line.as_bytes())));
        }
    }
    Statements {
        text: sound,
        maps: all_maps,
    }
}

fn is_texture(keyword: &str) -> bool {
    let keyword = keyword.to_ascii_lowercase();
    keyword.starts_with("map_") || matches!(keyword.as_str(), "bump" | "norm" | "disp" | "decal" | "refl")
}

/// Reads a colour. One number stands for three equal ones; values are not negative. Spectral files and XYZ are not
/// read.
fn color(values: &[&str]) -> Option<[f32; 3]> {
    let number = |text: &&str| number_in(&[*text], 0.0, f32::MAX);
    match values {
        [grey] => Some([number(grey)?; 3]),
        [r, g, b, ..] => Some([number(r)?, number(g)?, number(b)?]),
        _ => None,
    }
}

/// Reads a transmission filter, a colour that is at most white.
fn filter(values: &[&str]) -> Option<[f32; 3]> {
    color(values).filter(|color| color.iter().all(|channel| *channel <= 1.0))
}

fn number_in(values: &[&str], least: f32, most: f32) -> Option<f32> {
    let value: f32 = values.first()?.parse().ok()?;
    (least..=most).contains(&value).then_some(value)
}

fn convert(material: &tobj::Material, maps: MtlMaps) -> MtlMaterial {
    let absent = default_material(&material.name);
    let extra = |name: &str| material.unknown_param.get(name);
    let extension = |name: &str| extra(name).and_then(|text| text.parse::<f32>().ok());
    let has_color = material.specular.is_some() || material.emissive.is_some();
    MtlMaterial {
        kd: match material.diffuse {
            Some(kd) => Vec3::from(kd),
            None if has_color => Vec3::ZERO,
            None => absent.kd,
        },
        ks: material.specular.map_or(absent.ks, Vec3::from),
        ke: material.emissive.map_or(absent.ke, Vec3::from),
        ns: material.shininess.unwrap_or(absent.ns),
        ni: material.optical_density.unwrap_or(absent.ni),
        // `Tr` is the complement, and older; `d` counts if both are given.
        d: material
            .dissolve
            .or(extension("Tr").map(|tr| 1.0 - tr))
            .unwrap_or(absent.d),
        tf: extra("Tf").and_then(|text| triple(text)).unwrap_or(absent.tf),
        illum: material.illumination_model,
        pr: extension("Pr"),
        pm: extension("Pm"),
        maps,
        ..absent
    }
}

/// The three numbers of a colour, as [`sound_statements`] writes them.
fn triple(text: &str) -> Option<Vec3> {
    let mut numbers = text.split_whitespace().map(|number| number.parse().ok());
    let mut next = || numbers.next()?;
    Some(Vec3::new(next()?, next()?, next()?))
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
