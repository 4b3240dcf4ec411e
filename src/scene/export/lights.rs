//! Exports lights and cameras as nodes.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::math::{Affine3A, Mat3, Quat, Vec3};

use super::extras::set_extras;
use super::messages::Messages;
use super::motion::{Motion, placed};
use super::poses::{Folders, pose_of, rigid};
use crate::color::Rgb;
use crate::files::Access;
use crate::gltf::profiles::node_from_lamp;
use crate::gltf::write::GltfWriter;
use crate::gltf::write::model::{Camera, Light, Node, NodeProfile, Orthographic, Perspective, Projection, Spot};
use crate::photometry::LUMENS_PER_WATT;
use crate::scene::assets::lamp_file::{MeasuredLamp, measured_lamp, standard_light};
use crate::scene::components::description::{EmitterDescription, Identity, SensorDescription};
use crate::scene::{Cone, EmitterKind, FovAxis, Lens, SunSky};

/// The parts of an export used for lights and cameras.
pub(super) struct Stage<'s> {
    pub writer: &'s mut GltfWriter,
    pub folders: &'s mut Folders,
    pub messages: &'s mut Messages,
    pub access: &'s Access,
    /// Whether lightmaps beside the file hold the light that glTF cannot express, so that its absence is not reported.
    pub is_baked: bool,
}

/// A light without a name. `power` is its intensity in W/sr or irradiance in W/m^2, which the file has in candela and
/// lux.
fn light_of(kind: &'static str, power: Rgb, spot: Option<Spot>) -> Light {
    let power = power.max(Rgb::ZERO);
    let most = power.max_element();
    let color = if most > 0.0 { power / most } else { Rgb::ONE };
    Light {
        name: String::new(),
        kind,
        color: color.to_array(),
        intensity: (most * LUMENS_PER_WATT).min(f32::MAX),
        spot,
    }
}

fn spot_of(cone: &Cone) -> Spot {
    let outer = cone.cutoff_angle.to_radians().clamp(1e-4, FRAC_PI_2);
    Spot {
        // glTF requires it to be less.
        inner_cone_angle: cone.beam_width.to_radians().clamp(0.0, outer * (1.0 - 1e-4)),
        outer_cone_angle: outer,
    }
}

impl Stage<'_> {
    /// Adds a light.
    pub fn light(&mut self, about: &EmitterDescription) {
        let name = &*about.identity.name;
        let (kind, power, spot) = match &about.emitter.kind {
            EmitterKind::Point { intensity } => ("point", *intensity, None),
            EmitterKind::Directional { irradiance } => ("directional", *irradiance, None),
            EmitterKind::Spot {
                intensity,
                cone,
                texture,
            } => {
                if texture.is_some() {
                    self.messages.note("light", name, "the slide is left out");
                }
                ("spot", *intensity, Some(spot_of(cone)))
            }
            EmitterKind::Constant { .. }
            | EmitterKind::Environment { .. }
            | EmitterKind::SunSky(_)
            | EmitterKind::Projector { .. }
                if self.is_baked =>
            {
                return;
            }
            // A bake writes them to files of their own.
            EmitterKind::ReflectionProbe { .. } | EmitterKind::IrradianceVolume { .. } if self.is_baked => {
                return;
            }
            EmitterKind::ReflectionProbe { .. } => return self.leave_out_probe("reflection probe", name),
            EmitterKind::IrradianceVolume { .. } => return self.leave_out_probe("irradiance volume", name),
            EmitterKind::IlluminanceMeter { .. } | EmitterKind::IlluminanceGrid { .. } if self.is_baked => return,
            EmitterKind::IlluminanceMeter { .. } => return self.leave_out(name, "a measuring point"),
            EmitterKind::IlluminanceGrid { .. } => return self.leave_out(name, "a measuring grid"),
            EmitterKind::MarkerPoint | EmitterKind::MarkerBox | EmitterKind::MarkerSphere | EmitterKind::MarkerPath => {
                return self.marker(about);
            }
            EmitterKind::Constant { .. } => return self.leave_out(name, "light from all directions"),
            EmitterKind::Environment { .. } => return self.leave_out(name, "an environment map"),
            EmitterKind::SunSky(sky) => return self.sun(about, sky),
            EmitterKind::Projector { .. } => return self.leave_out(name, "a projector"),
            EmitterKind::Luminaire { .. } => return self.lamp(about),
        };
        let light = light_of(kind, power, spot);
        // Lights of glTF shine along -z.
        let turned = |map: &Affine3A| Some(rigid(map)? * Affine3A::from_rotation_y(PI));
        self.stand(
            "light",
            &about.identity,
            &about.to_world,
            &turned,
            |writer, node, leaf, parent| {
                let name = leaf.to_owned();
                writer.add_light(node, Light { name, ..light }, parent)
            },
        );
    }

    /// Adds a lamp with measured intensities as a spot or a point light.
    fn lamp(&mut self, about: &EmitterDescription) {
        let name = &*about.identity.name;
        match standard_light(&about.emitter, self.access) {
            Some(Ok(kind)) => {
                let standard = EmitterDescription {
                    emitter: kind.into(),
                    ..about.clone()
                };
                // Games, for which levels are baked, have no profiles.
                let measured = measured_lamp(&about.emitter, self.access).filter(|_| !self.is_baked);
                match measured {
                    Some(lamp) => self.measured(&standard, lamp),
                    None => {
                        let what = "it keeps its flux, but shines as a spot or a point light, without the intensities of its file";
                        self.messages.note("light", name, what);
                        self.light(&standard);
                    }
                }
            }
            Some(Err(error)) => self.messages.left_out("light", name, error),
            None => {}
        }
    }

    /// Adds a lamp by its file, with a standard light at the same node for programs that have no profiles.
    fn measured(&mut self, standard: &EmitterDescription, lamp: MeasuredLamp) {
        let (power, spot) = match &standard.emitter.kind {
            EmitterKind::Spot { intensity, cone, .. } => (*intensity, Some(spot_of(cone))),
            EmitterKind::Point { intensity } => (*intensity, None),
            _ => return self.light(standard),
        };
        let light = light_of(if spot.is_some() { "spot" } else { "point" }, power, spot);
        let most = lamp.factor.max_element().max(0.0);
        let color = if most > 0.0 { lamp.factor / most } else { Rgb::ONE };
        let profile = NodeProfile {
            light: self.writer.add_profile(lamp.bytes),
            multiplier: most.min(f32::MAX),
            color: color.max(Rgb::ZERO).to_array(),
        };
        let turn = Affine3A::from_mat4(node_from_lamp(lamp.geometry).transpose());
        self.stand(
            "light",
            &standard.identity,
            &standard.to_world,
            &|map: &Affine3A| Some(rigid(map)? * turn),
            |writer, mut node, leaf, parent| {
                node.extensions.profile = Some(profile);
                let name = leaf.to_owned();
                writer.add_light(node, Light { name, ..light }, parent)
            },
        );
    }

    /// Adds the sun of a sky as a directional light.
    fn sun(&mut self, about: &EmitterDescription, sky: &SunSky) {
        let name = &*about.identity.name;
        let atmosphere = rigid(&about.to_world).and_then(|turn| {
            let turn = Mat3::from(turn.matrix3);
            let atmosphere = sky.atmosphere(turn)?;
            Some((turn * atmosphere.sun_direction, atmosphere.sun_irradiance()))
        });
        let shines = |(_, power): &(Vec3, Rgb)| power.max_element() > 0.0;
        let Some((direction, power)) = atmosphere.filter(shines) else {
            return self.leave_out(name, "a sky with its sun");
        };
        let what = "only the sun is kept, as light from one direction, without the light of the sky";
        self.messages.note("light", name, what);
        if about.identity.keys.is_some() {
            self.messages.note("light", name, "the sun stands still");
        }
        let identity = Identity {
            keys: None,
            ..about.identity.clone()
        };
        // Lights of glTF shine along -z.
        let from_sun = Affine3A::from_quat(Quat::from_rotation_arc(Vec3::Z, direction));
        let light = light_of("directional", power, None);
        self.stand(
            "light",
            &identity,
            &from_sun,
            &|map| Some(*map),
            |writer, node, leaf, parent| {
                let name = leaf.to_owned();
                writer.add_light(node, Light { name, ..light }, parent)
            },
        );
    }

    /// Adds a marker as a node without a mesh, with its form beside its properties.
    fn marker(&mut self, about: &EmitterDescription) {
        let is_point = about.emitter.kind == EmitterKind::MarkerPoint;
        // What is sheared stands straight, since a node cannot be sheared.
        let straight = |map: &Affine3A| pose_of(map).map(|_| *map).or_else(|| rigid(map));
        // The direction of a point is -z, as of lights and cameras of glTF. Other forms have an extent of their own.
        let turned = |map: &Affine3A| match is_point {
            true => Some(straight(map)? * Affine3A::from_rotation_y(PI)),
            false => straight(map),
        };
        let form = about.emitter.form().unwrap_or_default();
        self.stand(
            "light",
            &about.identity,
            &about.to_world,
            &turned,
            |writer, node, _, parent| {
                let node = writer.add_node(node, parent);
                writer.add_extras(node, serde_json::json!({ "marker": form }));
                node
            },
        );
    }

    fn leave_out(&mut self, name: &str, what: &str) {
        self.messages
            .left_out("light", name, format!("glTF has no counterpart of {what}"));
    }

    fn leave_out_probe(&mut self, kind: &'static str, name: &str) {
        self.messages.left_out(
            kind,
            name,
            "glTF has no place for it; `sunroom bake` writes it beside the level",
        );
    }

    /// Adds a camera.
    pub fn camera(&mut self, about: &SensorDescription) {
        let name = &*about.identity.name;
        let sensor = &about.sensor;
        let mut lost = |what: &str| self.messages.note("camera", name, what);
        if let Lens::Thin { .. } = sensor.lens {
            lost("the lens is lost, and the picture is sharp everywhere");
        }
        if sensor.principal_point_offset != bevy::math::Vec2::ZERO {
            lost("the offset of the picture is left out");
        }
        if about.film.crop.is_some() {
            lost("the crop of the film is left out");
        }
        if sensor.shutter_close > sensor.shutter_open {
            lost("nothing that moves is blurred");
        }
        let aspect = about.film.width as f32 / about.film.height as f32;
        let (near, far) = (sensor.near_clip.max(f32::MIN_POSITIVE), sensor.far_clip);
        let projection = match sensor.lens {
            Lens::Pinhole | Lens::Thin { .. } => {
                let along_x = sensor.fov_axis.horizontal(sensor.fov, aspect);
                let perspective = Perspective {
                    aspect_ratio: Some(aspect),
                    yfov: FovAxis::Y.of_horizontal(along_x, aspect).to_radians(),
                    znear: near,
                    zfar: Some(far.max(near * 1.001)),
                };
                Projection::Perspective { perspective }
            }
            Lens::Orthographic => {
                let half = |axis: bevy::math::Vec3A| axis.length().max(f32::MIN_POSITIVE);
                let orthographic = Orthographic {
                    xmag: half(about.to_world.matrix3.x_axis),
                    ymag: half(about.to_world.matrix3.y_axis) / aspect,
                    znear: near,
                    zfar: far.max(near * 1.001),
                };
                Projection::Orthographic { orthographic }
            }
        };
        // Cameras of glTF look along -z with +x to the right.
        let turned = |map: &Affine3A| Some(rigid(map)? * Affine3A::from_rotation_y(PI));
        self.stand(
            "camera",
            &about.identity,
            &about.to_world,
            &turned,
            |writer, node, leaf, parent| {
                let name = leaf.to_owned();
                let camera = Some(writer.add_camera(Camera { name, projection }));
                writer.add_node(Node { camera, ..node }, parent)
            },
        );
    }

    /// Adds the node of a thing without extent; `turned` converts a pose of the scene to one of glTF.
    fn stand(
        &mut self,
        kind: &'static str,
        identity: &Identity,
        to_world: &Affine3A,
        turned: &dyn Fn(&Affine3A) -> Option<Affine3A>,
        add: impl FnOnce(&mut GltfWriter, Node, &str, Option<usize>) -> usize,
    ) {
        let name = &*identity.name;
        let Some(world) = turned(to_world) else {
            self.messages.left_out(kind, name, "the transform cannot be inverted");
            return;
        };
        let mut branch = self.folders.branch(name, self.writer);
        let mut pose = pose_of(&(branch.world_from_parent.inverse() * world));
        if pose.is_none() {
            // The folder's transform would shear it.
            branch.parent = None;
            branch.world_from_parent = Affine3A::IDENTITY;
            pose = pose_of(&world);
        }
        let node = Node {
            name: branch.leaf.clone(),
            pose: pose.unwrap_or_default(),
            order: Some(identity.order),
            ..Node::default()
        };
        let node = add(self.writer, node, &branch.leaf, branch.parent);
        set_extras(self.writer, node, identity.properties.as_ref());
        if let Some(keys) = &identity.keys {
            let parent_from_world = branch.world_from_parent.inverse();
            let local = |value: &crate::document::Value| Some(parent_from_world * turned(&placed(value)?)?);
            let motion = Motion { keys, local: &local };
            motion.write(node, kind, name, self.writer, self.messages);
        }
    }
}
