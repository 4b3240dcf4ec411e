//! Interprets the materials of an OBJ's own library. MTL describes Phong-like shading, so this is an interpretation:
//!
//! | the library says | result |
//! |---|---|
//! | `illum` 6 or 7; `illum` 4 or 9 with an `Ni` other than 1 | clear glass of index `Ni` (1.5 if that is 1), through which light comes out in the colour `Tf` |
//! | `Pm` > 0.5 | rough metal in the colour `Kd`, alpha = max(`Pr`, 0.03)² |
//! | `illum` 3 or 5 with a `Kd` as good as black | a mirror in the colour `Ks` |
//! | anything else | diffuse `Kd` |
//! | `Ke` above 0 | emits that radiance as well |
//! | `map_Kd` | diffuse in the colours of the picture |
//! | `map_Ke` | emits the colours of the picture |
//! | `norm` | shaded about the normals of the picture |
//! | `bump` | bumped by the picture times `-bm`, in units of the mesh; a normal map if the picture holds normals |
//! | `d` < 1, `map_d` | this opacity, or the brightness of the picture as opacity |
//!
//! All but glass are seen from both sides: such files do not specify sides, and many have their triangles oriented at
//! random.

use super::Checker;
use super::bsdf::PERFECT_MIRROR;
use super::texture::TexturePacker;
use crate::color::{BRIGHTEST, Rgb};
use crate::geometry::mesh::MtlMaterial;
use crate::geometry::mtl::MtlModel;
use crate::geometry::mtl_map::MtlMap;
use crate::material::{BumpOptions, Material, MaterialId, TexturedBsdf};
use crate::scene::assets::mtl_picture::mtl_picture;
use crate::scene::parameters::{INDICES, PRINCIPLED_ETA};
use crate::shading::{
    Bsdf, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Microfacet, MicrofacetKind,
    RoughConductor,
};
use crate::texture::Parameter;

/// Appends the materials that one library material becomes to `materials` and returns the id of the one to use.
pub(in crate::engine) fn push_mtl(
    mtl: &MtlMaterial,
    model: DielectricModel,
    textures: &mut TexturePacker,
    materials: &mut Vec<Material>,
    errors: &mut Vec<String>,
) -> MaterialId {
    let mut check = Checker {
        name: &mtl.name,
        errors,
    };
    let mut push = |material| {
        materials.push(material);
        MaterialId(materials.len() as u32 - 1)
    };
    let bsdf = one_sided(mtl, model, &mut check);
    let mut id = match (&mtl.maps.kd, bsdf) {
        (Some(map), Bsdf::Diffuse(_)) => push(Material::Textured(TexturedBsdf::Diffuse {
            reflectance: textures.parameter(&mtl_picture(map, false)),
        })),
        _ => push(bsdf.into()),
    };
    if matches!(bsdf, Bsdf::Dielectric(_)) {
        return id;
    }
    let options = BumpOptions {
        flip_invalid_normals: true,
        use_shadowing_function: true,
    };
    let bump = mtl.maps.bump.as_ref().map(|map| (map, has_normals(map, textures)));
    let norm = mtl.maps.norm.as_ref().map(|map| (map, true));
    for (map, has_normals) in [bump, norm].into_iter().flatten() {
        let picture = mtl_picture(map, true);
        id = push(match has_normals {
            true => Material::NormalMap {
                nested: id,
                normals: textures.parameter(&picture),
                gltf_tangents: true,
                options,
            },
            false => Material::BumpMap {
                nested: id,
                height: textures.parameter(&picture),
                scale: map.bump,
                options,
            },
        });
    }
    id = push(Material::TwoSided { front: id, back: id });
    let opacity = match &mtl.maps.d {
        Some(map) => textures.parameter(&mtl_picture(map, true)),
        None => Parameter::Constant(mtl.d),
    };
    match opacity {
        Parameter::Constant(1.0) => id,
        opacity => push(Material::Mask { nested: id, opacity }),
    }
}

/// Whether the picture of a `bump` statement holds normals, as written by exporters such as Blender's: its mean is
/// light blue, which heights never are.
fn has_normals(map: &MtlMap, textures: &TexturePacker) -> bool {
    const UPRIGHT: Rgb = Rgb::new(0.5, 0.5, 0.9);
    let is_upright = |mean: Rgb| (mean - UPRIGHT).abs().max_element() < 0.15;
    textures
        .picture(&map.file)
        .is_some_and(|image| is_upright(image.mean(true)))
}

/// The emission of a material; zero if it is black. Invalid colours have been reported with the other parameters or do
/// not matter.
pub(super) fn emission(mtl: &MtlMaterial, textures: &mut TexturePacker) -> Parameter<Rgb> {
    match &mtl.maps.ke {
        Some(map) => textures.parameter(&mtl_picture(map, false)),
        None => Parameter::Constant(mtl.ke.max(Rgb::ZERO).min(Rgb::splat(BRIGHTEST))),
    }
}

fn one_sided(mtl: &MtlMaterial, model: DielectricModel, check: &mut Checker) -> Bsdf {
    let metal = |color: Rgb| ConductorSpecular {
        eta: PERFECT_MIRROR.0,
        k: PERFECT_MIRROR.1,
        specular_reflectance: color,
    };
    match mtl.model() {
        MtlModel::Glass { index } => Bsdf::Dielectric(Dielectric {
            eta: check.number("Ni", index, *INDICES.start(), *INDICES.end(), PRINCIPLED_ETA.usual),
            model,
            specular_reflectance: Rgb::ONE,
            // The filter is for the whole object, whose surface light crosses twice.
            specular_transmittance: check.reflectance("Tf", mtl.tf).powf(0.5),
        }),
        MtlModel::Metal { roughness } => {
            let roughness = check
                .number("Pr", roughness, 0.0, 1.0, 0.5)
                .max(MtlModel::LEAST_ROUGHNESS);
            Bsdf::RoughConductor(RoughConductor {
                specular: metal(check.reflectance("Kd", mtl.kd)),
                distribution: Microfacet::new(MicrofacetKind::Ggx, roughness * roughness, roughness * roughness),
                multiple_scattering: Compensation::NONE,
            })
        }
        MtlModel::Mirror => Bsdf::Conductor(Conductor {
            specular: metal(check.reflectance("Ks", mtl.ks)),
        }),
        MtlModel::Matt => Bsdf::Diffuse(Diffuse {
            reflectance: check.reflectance("Kd", mtl.kd),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mtl() -> MtlMaterial {
        MtlMaterial {
            name: "m".into(),
            kd: Rgb::splat(0.6),
            ks: Rgb::splat(0.9),
            ke: Rgb::ZERO,
            ns: 10.0,
            ni: 1.0,
            d: 1.0,
            tf: Rgb::ONE,
            illum: Some(2),
            pr: None,
            pm: None,
            maps: Default::default(),
        }
    }

    fn packed(mtl: MtlMaterial) -> (Bsdf, bool) {
        let (mut materials, mut errors) = (Vec::new(), Vec::new());
        let mut textures = TexturePacker::new(&|_| None);
        let id = push_mtl(&mtl, DielectricModel::Exact, &mut textures, &mut materials, &mut errors);
        assert_eq!(errors, [""; 0]);
        let Material::Plain(bsdf) = materials[0] else {
            panic!("{materials:?}")
        };
        (bsdf, matches!(materials[id.0 as usize], Material::TwoSided { .. }))
    }

    #[test]
    fn table_of_the_interpretation() {
        let diffuse = |bsdf: &Bsdf| matches!(bsdf, Bsdf::Diffuse(d) if d.reflectance == Rgb::splat(0.6));
        let glass = |ni: f32| move |bsdf: &Bsdf| matches!(bsdf, Bsdf::Dielectric(d) if d.eta == ni && d.specular_transmittance == Rgb::ONE);
        let green =
            |bsdf: &Bsdf| matches!(bsdf, Bsdf::Dielectric(d) if d.specular_transmittance == Rgb::new(0.5, 1.0, 0.0));
        let filter = Rgb::new(0.25, 1.0, 0.0);
        let mirror =
            |bsdf: &Bsdf| matches!(bsdf, Bsdf::Conductor(c) if c.specular.specular_reflectance == Rgb::splat(0.9));
        let rough = |bsdf: &Bsdf| matches!(bsdf, Bsdf::RoughConductor(r) if r.distribution == Microfacet::new(MicrofacetKind::Ggx, 0.25, 0.25));
        type Expected<'a> = &'a dyn Fn(&Bsdf) -> bool;
        let plain = mtl();
        let table: [(&str, MtlMaterial, Expected, bool); 11] = [
            ("plain", plain.clone(), &diffuse, true),
            (
                "opaque with an index",
                MtlMaterial {
                    ni: 1.5,
                    ..plain.clone()
                },
                &diffuse,
                true,
            ),
            (
                "clear without an index",
                MtlMaterial {
                    d: 0.2,
                    ..plain.clone()
                },
                &diffuse,
                false,
            ),
            (
                "clear with an index",
                MtlMaterial {
                    d: 0.2,
                    ni: 1.3,
                    ..plain.clone()
                },
                &diffuse,
                false,
            ),
            (
                "illum 7",
                MtlMaterial {
                    illum: Some(7),
                    ..plain.clone()
                },
                &glass(1.5),
                false,
            ),
            (
                "illum 9",
                MtlMaterial {
                    ni: 1.4,
                    illum: Some(9),
                    ..plain.clone()
                },
                &glass(1.4),
                false,
            ),
            (
                "green glass",
                MtlMaterial {
                    tf: filter,
                    illum: Some(7),
                    ..plain.clone()
                },
                &green,
                false,
            ),
            (
                "a filter of what is opaque",
                MtlMaterial {
                    tf: filter,
                    ni: 1.5,
                    ..plain.clone()
                },
                &diffuse,
                true,
            ),
            (
                "metallic",
                MtlMaterial {
                    pm: Some(1.0),
                    pr: Some(0.5),
                    ..plain.clone()
                },
                &rough,
                true,
            ),
            (
                "shiny paint",
                MtlMaterial {
                    illum: Some(5),
                    ..plain.clone()
                },
                &diffuse,
                true,
            ),
            (
                "mirror",
                MtlMaterial {
                    illum: Some(5),
                    kd: Rgb::splat(0.01),
                    ..plain
                },
                &mirror,
                true,
            ),
        ];
        for (what, material, expected, two_sided) in table {
            let (bsdf, is_two_sided) = packed(material);
            assert!(expected(&bsdf), "{what}: {bsdf:?}");
            assert_eq!(is_two_sided, two_sided, "{what}");
        }
    }
}
