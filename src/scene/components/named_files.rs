//! The file paths in things of the scene, mutable for files that have moved.

use std::path::PathBuf;

use super::parameters::ParameterMut;
use crate::scene::{AreaLight, Declared, Emitter, Material, Medium, ParameterInfo, Shape, ShapeKind, Texture};

/// A thing with file paths.
pub(crate) trait NamesFiles {
    /// Calls `meet` with the absolute path of each file, mutable.
    fn for_each_file(&mut self, meet: &mut dyn FnMut(&mut PathBuf));
}

impl NamesFiles for Shape {
    fn for_each_file(&mut self, meet: &mut dyn FnMut(&mut PathBuf)) {
        if let ShapeKind::Mesh(file) = &mut self.kind {
            meet(&mut file.path);
        }
    }
}

impl NamesFiles for Medium {
    fn for_each_file(&mut self, meet: &mut dyn FnMut(&mut PathBuf)) {
        self.for_each_grid_mut(&mut |grid| meet(&mut grid.path));
    }
}

macro_rules! names_files_by_parameters {
    ($($Thing:ty),*) => {$(
        impl NamesFiles for $Thing {
            fn for_each_file(&mut self, meet: &mut dyn FnMut(&mut PathBuf)) {
                self.visit_mut(&mut |info, value| of_parameter(info, value, meet));
            }
        }
    )*};
}

names_files_by_parameters!(Material, AreaLight, Emitter);

fn of_parameter(info: &'static ParameterInfo, value: ParameterMut, meet: &mut dyn FnMut(&mut PathBuf)) {
    if let ParameterMut::Picture(path) = value {
        meet(path);
        return;
    }
    value.for_each_texture(info, &mut |_, texture| of_texture(texture, meet));
}

fn of_texture(texture: &mut Texture, meet: &mut dyn FnMut(&mut PathBuf)) {
    if let Texture::Bitmap(bitmap) = texture {
        meet(&mut bitmap.path);
    }
    texture.for_each_nested_mut(&mut |nested| of_texture(nested, meet));
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::document;
    use crate::scene::read::read;

    /// Every kind of file in a scene is visited, once for each use.
    #[test]
    fn all_files_of_a_scene_are_met() {
        let bitmap = |name: &str, file: &str| {
            format!("<texture type='bitmap' name='{name}'><string name='filename' value='{file}'/></texture>")
        };
        let text = format!(
            "<scene version='3.0.0'>
            <shape type='obj'><string name='filename' value='a.obj'/>
              <bsdf type='roughconductor'>{}<texture type='checkerboard' name='specular_reflectance'>{}</texture></bsdf>
              <emitter type='area'>{}</emitter></shape>
            <emitter type='envmap'><string name='filename' value='e.exr'/></emitter>
            <emitter type='spot'>{}</emitter>
            <emitter type='projector'>{}</emitter>
            <bsdf type='diffuse' id='painted'><texture type='mesh_attribute' name='reflectance'><string name='name' value='vertex_color'/>{}</texture></bsdf>
            <shape type='sphere'><medium name='interior' type='heterogeneous'>
              <volume type='gridvolume' name='sigma_t'><string name='filename' value='h.vol'/></volume>
              <volume type='vdbvolume' name='albedo'><string name='filename' value='i.vdb'/></volume>
              <volume type='gridvolume' name='emission'><string name='filename' value='j.vol'/></volume>
              <phase type='blendphase'><volume type='gridvolume' name='weight'><string name='filename' value='k.vol'/></volume>
                <phase type='isotropic'/><phase type='hg'/></phase>
            </medium></shape></scene>",
            bitmap("alpha", "b.png"),
            bitmap("color1", "c.png"),
            bitmap("radiance", "d.png"),
            bitmap("texture", "f.png"),
            bitmap("irradiance", "g.png"),
            bitmap("times", "l.png"),
        );
        let mut document = document::parse_str(&*text, Path::new("/nowhere/scene.xml"), &[]);
        let mut scene = read(&mut document);
        let noted = scene.missing.len();
        let mut met = Vec::new();
        let mut meet = |path: &mut PathBuf| {
            met.push(path.file_name().unwrap_or_default().to_string_lossy().into_owned());
            path.push("moved");
        };
        for shape in &mut scene.shapes {
            shape.shape.for_each_file(&mut meet);
            shape
                .area_light
                .iter_mut()
                .for_each(|light| light.for_each_file(&mut meet));
        }
        scene
            .materials
            .iter_mut()
            .for_each(|it| it.material.for_each_file(&mut meet));
        scene
            .emitters
            .iter_mut()
            .for_each(|it| it.emitter.for_each_file(&mut meet));
        scene.media.iter_mut().for_each(|it| it.medium.for_each_file(&mut meet));
        met.sort();
        let expected = [
            "a.obj", "b.png", "c.png", "d.png", "e.exr", "f.png", "g.png", "h.vol", "i.vdb", "j.vol", "k.vol", "l.png",
        ];
        assert_eq!(met, expected);
        assert_eq!(noted, expected.len(), "all of them are missing");
        let mut again = 0;
        scene.media[0]
            .medium
            .for_each_file(&mut |path| again += usize::from(path.ends_with("moved")));
        assert_eq!(again, 4);
    }
}
