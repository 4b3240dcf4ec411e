//! Packs the list of the scene's media for the renderer: references become ids, and files become grids.

use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::math::{Affine3A, UVec3};
use bevy::prelude::*;

use super::Checker;
use crate::color::Rgb;
use crate::math::Aabb;
use crate::medium::{
    self, BlendedPhase, GridVolume, MediumId, MediumSource, Phase, TabulatedPhase, Volume, VolumeGrid, Voxels,
};
use crate::scene::{GridFile, Medium, PhaseFunction, VolumeFilter, VolumeMap, VolumeParameter, VolumeWrap};

/// A medium entity as read by extraction.
#[derive(Clone, Debug)]
pub(in crate::engine) struct AuthoredMedium<'a> {
    pub entity: Entity,
    pub name: String,
    pub medium: &'a Medium,
}

/// The sources of the renderer's media in the order of the authored ones, and the id of each entity.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::engine) struct PackedMedia {
    pub sources: Vec<MediumSource>,
    /// The name of each medium in messages.
    pub names: Vec<String>,
    pub ids: Arc<EntityHashMap<MediumId>>,
}

/// Packs all media of a scene. `volumes` looks up files that have been loaded.
pub(in crate::engine) fn pack_media<'v>(
    authored: &[AuthoredMedium],
    volumes: &dyn Fn(&GridFile) -> Option<&'v VolumeMap>,
    errors: &mut Vec<String>,
) -> PackedMedia {
    let (mut sources, mut names, mut ids) = (Vec::new(), Vec::new(), EntityHashMap::default());
    for AuthoredMedium { entity, name, medium } in authored {
        ids.insert(*entity, MediumId(sources.len() as u32));
        let mut packer = MediumPacker {
            volumes,
            check: Checker { name, errors },
        };
        sources.push(packer.pack(medium));
        names.push(name.clone());
    }
    PackedMedia {
        sources,
        names,
        ids: Arc::new(ids),
    }
}

/// Packs a medium outside of any scene. Its grid files are ignored, and invalid numbers are replaced.
pub(crate) fn pack_medium_without_files(medium: &Medium) -> MediumSource {
    let mut packer = MediumPacker {
        volumes: &|_| None,
        check: Checker {
            name: "",
            errors: &mut Vec::new(),
        },
    };
    packer.pack(medium)
}

struct MediumPacker<'v, 'e, 'f> {
    volumes: &'f dyn Fn(&GridFile) -> Option<&'v VolumeMap>,
    check: Checker<'e>,
}

impl MediumPacker<'_, '_, '_> {
    fn pack(&mut self, medium: &Medium) -> MediumSource {
        let medium = &self.check.medium(medium);
        let (sigma_t, albedo) = medium.coefficients.sigma_t_and_albedo();
        let emission = self.color(&medium.emission, Rgb::ZERO);
        MediumSource {
            sigma_t: match &sigma_t {
                // A box is the only voxel of a grid, outside of which there is nothing.
                VolumeParameter::Box { value, to_world } => {
                    self.boxed(*value, *to_world).unwrap_or(Volume::Constant(Rgb::ZERO))
                }
                other => self.color(other, Rgb::ZERO),
            },
            scale: medium.scale,
            albedo: self.color(&albedo, Rgb::ONE),
            emission: scaled(emission, medium.emission_scale),
            phase: self.phase(&medium.phase),
        }
    }

    /// A colour in space; `otherwise` while its file is not available.
    fn color(&mut self, volume: &VolumeParameter<Rgb>, otherwise: Rgb) -> Volume {
        match volume {
            VolumeParameter::Constant(value) | VolumeParameter::Box { value, .. } => Volume::Constant(*value),
            VolumeParameter::Grid(grid) => self.grid(grid).unwrap_or(Volume::Constant(otherwise)),
        }
    }

    fn grid(&mut self, file: &GridFile) -> Option<Volume> {
        let map = (self.volumes)(file)?;
        let mut world_from_local = file.to_world * map.world_from_local;
        match map.bounds {
            Some(Aabb { min, max }) if file.use_grid_bbox => {
                world_from_local = world_from_local * Affine3A::from_translation(min) * Affine3A::from_scale(max - min);
            }
            None if file.use_grid_bbox => {
                let name = file.path.display();
                self.check
                    .report(format_args!("{name} names no box for its grid: it fills the unit cube"));
            }
            _ => {}
        }
        let filter = match file.filter {
            VolumeFilter::Nearest => medium::VolumeFilter::Nearest,
            VolumeFilter::Trilinear => medium::VolumeFilter::Trilinear,
        };
        let wrap = match file.wrap {
            VolumeWrap::Clamp => medium::VolumeWrap::Clamp,
            VolumeWrap::Repeat => medium::VolumeWrap::Repeat,
            VolumeWrap::Mirror => medium::VolumeWrap::Mirror,
        };
        self.placed(map.grid.clone(), world_from_local, filter, wrap)
    }

    /// A constant value within a box.
    fn boxed(&mut self, value: Rgb, world_from_unit: Affine3A) -> Option<Volume> {
        let voxel = VolumeGrid::new(UVec3::ONE, 3, Voxels::F32(value.to_array().to_vec())).ok()?;
        let (filter, wrap) = (medium::VolumeFilter::Nearest, medium::VolumeWrap::Clamp);
        self.placed(Arc::new(voxel), world_from_unit, filter, wrap)
    }

    fn placed(
        &mut self,
        grid: Arc<VolumeGrid>,
        world_from_local: Affine3A,
        filter: medium::VolumeFilter,
        wrap: medium::VolumeWrap,
    ) -> Option<Volume> {
        if !crate::math::is_invertible(&world_from_local) {
            self.check
                .report("the transform of a volume cannot be inverted: it is left out");
            return None;
        }
        Some(Volume::Grid(GridVolume::new(grid, world_from_local, filter, wrap)))
    }

    fn phase(&mut self, phase: &PhaseFunction) -> Phase {
        match phase {
            PhaseFunction::Isotropic => Phase::Isotropic,
            PhaseFunction::HenyeyGreenstein { g } => Phase::HenyeyGreenstein { g: *g },
            PhaseFunction::Rayleigh => Phase::Rayleigh,
            // An unusable table has been replaced and reported.
            PhaseFunction::Tabulated { values } => {
                TabulatedPhase::new(values).map_or(Phase::Isotropic, |table| Phase::Tabulated(Arc::new(table)))
            }
            PhaseFunction::Blend(blend) => {
                let weight = match &blend.weight {
                    VolumeParameter::Constant(share) | VolumeParameter::Box { value: share, .. } => {
                        Volume::Constant(Rgb::splat(*share))
                    }
                    VolumeParameter::Grid(grid) => self.grid(grid).unwrap_or(Volume::Constant(Rgb::splat(0.5))),
                };
                let of = blend.of.each_ref().map(|part| self.phase(part));
                Phase::Blend(Box::new(BlendedPhase { weight, of }))
            }
        }
    }
}

fn scaled(volume: Volume, factor: f32) -> Volume {
    match volume {
        Volume::Constant(value) => Volume::Constant(value * factor),
        Volume::Grid(mut grid) => {
            grid.scale *= factor;
            Volume::Grid(grid)
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;
    use crate::scene::{Coefficients, PhaseBlend};

    fn packed(medium: &Medium, map: Option<&VolumeMap>) -> (MediumSource, Vec<String>) {
        let mut errors = Vec::new();
        let authored = AuthoredMedium {
            entity: Entity::PLACEHOLDER,
            name: "fog".to_owned(),
            medium,
        };
        let mut packed = pack_media(&[authored], &|_| map, &mut errors);
        assert_eq!(packed.ids[&Entity::PLACEHOLDER], MediumId(0));
        (packed.sources.remove(0), errors)
    }

    fn smoke(bounds: Option<Aabb>) -> VolumeMap {
        let grid = VolumeGrid::new(UVec3::new(2, 1, 1), 1, Voxels::F32(vec![1.0, 3.0])).expect("two voxels");
        VolumeMap {
            grid: Arc::new(grid),
            bounds,
            world_from_local: Affine3A::IDENTITY,
        }
    }

    fn of_density(sigma_t: VolumeParameter<Rgb>) -> Medium {
        Medium {
            coefficients: Coefficients::Extinction {
                sigma_t,
                albedo: Rgb::splat(0.5).into(),
            },
            ..Medium::default()
        }
    }

    #[test]
    fn nothing_that_is_no_number_gets_in() {
        let wild = Rgb::new(f32::NAN, f32::INFINITY, -1.0);
        let table = PhaseFunction::Tabulated { values: vec![f32::NAN] };
        let medium = Medium {
            coefficients: Coefficients::Separate {
                sigma_s: wild,
                sigma_a: wild,
            },
            scale: f32::NAN,
            emission: wild.into(),
            emission_scale: -1.0,
            phase: PhaseFunction::Blend(Box::new(PhaseBlend {
                weight: f32::NAN.into(),
                of: [PhaseFunction::HenyeyGreenstein { g: 7.0 }, table],
            })),
        };
        let (source, errors) = packed(&medium, None);
        let text = format!("{source:?}");
        assert!(
            !text.contains("NaN") && !text.contains("inf") && !text.contains('-'),
            "{text}"
        );
        assert_eq!(errors.len(), 8, "{errors:?}");
    }

    #[test]
    fn a_box_ends_and_a_grid_lies_where_its_file_says() {
        let to_world = Affine3A::from_scale(Vec3::splat(2.0));
        let full = of_density(VolumeParameter::Box {
            value: Rgb::new(1.0, 2.0, 3.0),
            to_world,
        });
        let (source, _) = packed(&full, None);
        let bounds = source.sigma_t.bounds().expect("a box");
        assert_eq!((bounds.min, bounds.max), (Vec3::ZERO, Vec3::splat(2.0)));
        assert_eq!(source.sigma_t.at(Vec3::splat(1.9)), Rgb::new(1.0, 2.0, 3.0));

        let file = GridFile {
            to_world,
            use_grid_bbox: true,
            ..GridFile::default()
        };
        let bounds = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::new(3.0, 1.0, 1.0),
        };
        let grid = of_density(VolumeParameter::Grid(file));
        let (source, errors) = packed(&grid, Some(&smoke(Some(bounds))));
        let world = source.sigma_t.bounds().expect("a box");
        assert_eq!((world.min, world.max), (2.0 * bounds.min, 2.0 * bounds.max));
        assert_eq!((source.sigma_t.at(Vec3::new(5.9, 0.0, 0.0)).x, errors.len()), (3.0, 0));
        // The file names no box.
        let (source, errors) = packed(&grid, Some(&smoke(None)));
        assert!(errors[0].contains("names no box"), "{errors:?}");
        assert_eq!(source.sigma_t.bounds().expect("a box").max, Vec3::splat(2.0));
        // The file's own box is used.
        let moved = VolumeMap {
            world_from_local: Affine3A::from_translation(Vec3::X),
            ..smoke(None)
        };
        let by_itself = of_density(VolumeParameter::Grid(GridFile {
            to_world,
            ..GridFile::default()
        }));
        let bounds = packed(&by_itself, Some(&moved)).0.sigma_t.bounds().expect("a box");
        assert_eq!((bounds.min, bounds.max), (2.0 * Vec3::X, Vec3::new(4.0, 2.0, 2.0)));
        // While the file is not loaded, the medium is empty.
        assert_eq!(packed(&grid, None).0.sigma_t, Volume::ZERO);
    }

    #[test]
    fn emission_has_its_factor_and_absorption_its_albedo() {
        let medium = Medium {
            emission: VolumeParameter::Grid(GridFile::default()),
            emission_scale: 4.0,
            coefficients: Coefficients::Separate {
                sigma_s: Rgb::splat(1.0),
                sigma_a: Rgb::splat(3.0),
            },
            scale: 2.0,
            ..Medium::default()
        };
        let (source, _) = packed(&medium, Some(&smoke(None)));
        assert_eq!(source.emission.at(Vec3::new(0.9, 0.5, 0.5)).x, 12.0);
        assert_eq!((source.sigma_t, source.scale), (Volume::Constant(Rgb::splat(4.0)), 2.0));
        assert_eq!(source.albedo, Volume::Constant(Rgb::splat(0.25)));
    }
}
