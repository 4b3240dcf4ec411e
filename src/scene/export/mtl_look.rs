//! Converts the materials of MTL libraries to the terms of glTF.

use super::level::Level;
use super::look::Look;
use super::looks::Looks;
use crate::geometry::mesh::MtlMaterial;
use crate::geometry::mtl::MtlModel;
use crate::scene::Parameter;
use crate::scene::assets::mtl_picture::mtl_picture;

impl Looks<'_, '_> {
    /// The look of a material of an MTL library.
    pub fn of_mtl(&mut self, mtl: &MtlMaterial) -> Look {
        let clear = Level::number(1.0);
        let mut look = match mtl.model() {
            MtlModel::Glass { index } => {
                return Look {
                    roughness: Level::number(0.0),
                    transmission: clear,
                    is_thick: true,
                    index,
                    specular: 1.0,
                    ..Look::matt(Level::Constant(mtl.tf))
                };
            }
            MtlModel::Metal { roughness } => {
                let roughness = roughness.clamp(MtlModel::LEAST_ROUGHNESS, 1.0);
                Look::metal(Level::Constant(mtl.kd), Level::number(roughness))
            }
            MtlModel::Mirror => Look::metal(Level::Constant(mtl.ks), Level::number(0.0)),
            MtlModel::Matt => Look::matt(match &mtl.maps.kd {
                Some(map) => Level::of_color(&Parameter::Texture(mtl_picture(map, false))),
                None => Level::Constant(mtl.kd),
            }),
        };
        look.is_two_sided = true;
        if let Some(map) = &mtl.maps.norm {
            look.normals = Some(Level::of_color(&Parameter::Texture(mtl_picture(map, true))));
            look.gltf_tangents = true;
        }
        if mtl.maps.bump.is_some() {
            self.lose(&mtl.name, "the bumps are left out");
        }
        look.opacity = match &mtl.maps.d {
            Some(map) => Level::of_number(&Parameter::Texture(mtl_picture(map, true))),
            None => Level::number(mtl.d),
        };
        look
    }
}
