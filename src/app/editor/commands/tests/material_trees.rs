//! Trees of materials that others become.

use super::super::materials::{self, build, use_preset};
use super::*;
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::presets::{self, Preset};
use crate::app::editor::session::history::{History, redo, undo};
use crate::scene::{
    DeclaredIn, IntegratorSettings, InteriorMedium, LengthUnit, Medium, ObjectState, PathPlugin, ShapeKind,
};

fn world() -> World {
    let mut world = World::new();
    world.init_resource::<History>();
    world.init_resource::<Selection>();
    world
}

fn apply(world: &mut World, target: Entity, tree: &MaterialTree) {
    let mut edit = Edit::begin(world);
    build(&mut edit, &[target], tree).expect("it fits");
    edit.finish("Edit".to_owned(), None);
}

fn tree_of(world: &World, material: Entity) -> MaterialTree {
    materials::tree_of(world, material).expect("a material")
}

fn materials(world: &mut World) -> usize {
    world.query::<&Material>().iter(world).count()
}

fn red() -> Material {
    Material::Diffuse {
        reflectance: Rgb::X.into(),
    }
}

#[test]
fn a_wrapper_goes_around_a_material_and_off_again() {
    let mut world = world();
    let paint = world.spawn((red(), DocumentOrder(3), Name::new("paint"))).id();
    let shape = world.spawn((Shape::default(), UsesMaterial(paint))).id();
    let plain = MaterialTree::from(red());
    for plugin in ["bumpmap", "twosided"] {
        let tree = MaterialTree::of(world.get(paint).expect("there"), &materials_inside(&world, paint));
        apply(&mut world, paint, &tree.wrapped(plugin));
    }
    assert_eq!(
        tree_of(&world, paint),
        plain.clone().wrapped("bumpmap").wrapped("twosided")
    );
    assert_eq!(world.get::<UsesMaterial>(shape), Some(&UsesMaterial(paint)));
    // The bump map is written inside of the two-sided one, the paint inside of the bump map.
    let bump = materials_inside(&world, paint)[0];
    let inner = materials_inside(&world, bump)[0];
    assert_eq!(world.get(bump), Some(&DeclaredIn(paint)));
    assert_eq!(world.get(inner), Some(&DeclaredIn(bump)));
    // Without two-sidedness the bump map replaces the two-sided material, around the very same paint.
    let off = MaterialTree::of(world.get(bump).expect("there"), &[inner]);
    apply(&mut world, paint, &off);
    assert_eq!(tree_of(&world, paint), plain.clone().wrapped("bumpmap"));
    assert_eq!(
        (materials_inside(&world, paint), materials(&mut world)),
        (vec![inner], 2)
    );
    assert_eq!(world.get(inner), Some(&DeclaredIn(paint)));
    for _ in 0..3 {
        undo(&mut world).expect("three steps");
    }
    assert_eq!((tree_of(&world, paint), materials(&mut world)), (plain.clone(), 1));
    for _ in 0..3 {
        redo(&mut world).expect("three steps");
    }
    assert_eq!(tree_of(&world, paint), plain.wrapped("bumpmap"));
}

#[test]
fn a_preset_is_one_step_for_all_that_is_selected() {
    let mut world = world();
    let paint = world.spawn((red(), DocumentOrder(3))).id();
    let [one, two, bare] = [Some(paint), Some(paint), None].map(|used| {
        let shape = world.spawn(Shape::default()).id();
        if let Some(used) = used {
            world.entity_mut(shape).insert(UsesMaterial(used));
        }
        shape
    });
    let before = [paint, one, two, bare].map(|entity| ObjectState::of(&world, entity));
    let cloth = MaterialTree::from(Material::of_plugin("principled").expect("a plugin")).wrapped("twosided");
    let mut edit = Edit::begin(&mut world);
    build(&mut edit, &[one, two, bare], &cloth).expect("it fits");
    edit.finish("Preset".to_owned(), None);
    for shape in [one, two, bare] {
        let used = world.get::<UsesMaterial>(shape).expect("a material").0;
        assert_eq!(tree_of(&world, used), cloth);
    }
    assert_eq!(materials(&mut world), 4);
    undo(&mut world).expect("one step");
    assert!(undo(&mut world).is_err());
    assert_eq!(
        [paint, one, two, bare].map(|entity| ObjectState::of(&world, entity)),
        before
    );
    assert_eq!(materials(&mut world), 1);
}

#[test]
fn a_preset_with_a_medium_fills_what_it_is_given_to_in_one_step() {
    let mut world = world();
    world.insert_resource(LengthUnit::Centimetre);
    world.insert_resource(IntegratorSettings {
        max_depth: Some(8),
        ..IntegratorSettings::default()
    });
    let shapes = [0; 2].map(|_| {
        let kind = ShapeKind::Cube;
        world
            .spawn(Shape {
                kind,
                ..Shape::default()
            })
            .id()
    });
    let presets = presets::built_in();
    let preset = |path: &str| presets.iter().find(|preset| preset.path() == path).expect(path);
    let give = |world: &mut World, path: &str, shapes: &[Entity]| {
        let mut edit = Edit::begin(world);
        use_preset(&mut edit, preset(path), shapes).expect("shapes");
        edit.finish(path.to_owned(), None);
    };
    let inside = |world: &World, shape: Entity| {
        let medium = world.get::<InteriorMedium>(shape)?.0;
        let scale = world.get::<Medium>(medium).expect("a medium").scale;
        Some((world.get::<SceneId>(medium).expect("an id").0.clone(), scale))
    };
    let media = |world: &mut World| world.query::<&Medium>().iter(world).count();
    let depth = |world: &World| {
        let settings = world.resource::<IntegratorSettings>();
        (settings.plugin, settings.max_depth)
    };
    give(&mut world, "Scattering/milk", &shapes);
    let milk = Some(("milk-inside".to_owned(), 10.0));
    for shape in shapes {
        assert_eq!(inside(&world, shape), milk);
        let used = world.get::<UsesMaterial>(shape).expect("a material").0;
        assert_eq!(tree_of(&world, used), preset("Scattering/milk").tree);
    }
    assert_eq!(
        (media(&mut world), depth(&world)),
        (1, (PathPlugin::VolPath, Some(1024)))
    );
    // Another one takes its place, and the medium that nothing is filled with any more goes.
    give(&mut world, "Scattering/jade", &shapes[..1]);
    assert_eq!(
        (inside(&world, shapes[0]).expect("jade").0.as_str(), media(&mut world)),
        ("jade-inside", 2)
    );
    give(&mut world, "Metal/gold", &shapes);
    assert_eq!((inside(&world, shapes[0]), inside(&world, shapes[1])), (None, None));
    assert_eq!(media(&mut world), 0);
    for _ in 0..2 {
        undo(&mut world).expect("a step");
    }
    assert_eq!((inside(&world, shapes[0]), media(&mut world)), (milk, 1));
    undo(&mut world).expect("a step");
    assert_eq!((inside(&world, shapes[1]), media(&mut world)), (None, 0));
    assert_eq!(depth(&world), (PathPlugin::Path, Some(8)));
    // A flat shape is left as it is.
    let kind = ShapeKind::Disk;
    let disk = world
        .spawn(Shape {
            kind,
            ..Shape::default()
        })
        .id();
    let mut edit = Edit::begin(&mut world);
    let refused = use_preset(&mut edit, preset("Scattering/milk"), &[disk]).map_err(|error| error.to_string());
    assert!(refused.is_err_and(|error| error.contains("only a closed shape")));
    edit.finish("Preset".to_owned(), None);
    // A medium that is the user's own stays.
    let own = world.spawn((Medium::default(), SceneId("milk-inside".to_owned()))).id();
    world.entity_mut(shapes[0]).insert(InteriorMedium(own));
    give(&mut world, "Glass/clear", &shapes);
    assert_eq!(world.get::<InteriorMedium>(shapes[0]), Some(&InteriorMedium(own)));
    give(&mut world, "Scattering/milk", &shapes);
    assert_eq!((world.get::<Medium>(own).is_some(), media(&mut world)), (true, 2));
}

#[test]
fn a_preset_is_there_once_however_often_it_is_used() {
    let mut world = world();
    let shapes = [0; 3].map(|_| world.spawn(Shape::default()).id());
    let preset = Preset {
        group: "Metal".to_owned(),
        name: "gold, satin".to_owned(),
        tree: MaterialTree::from(red()).wrapped("twosided"),
        medium: None,
    };
    let mut give = |shape: Entity| {
        let mut edit = Edit::begin(&mut world);
        use_preset(&mut edit, &preset, &[shape]).expect("a shape");
        edit.finish("Preset".to_owned(), None);
        let used = world.get::<UsesMaterial>(shape).expect("a material").0;
        assert_eq!(tree_of(&world, used), preset.tree);
        (used, world.get::<SceneId>(used).map(|id| id.0.clone()))
    };
    let first = give(shapes[0]);
    assert_eq!(first.1.as_deref(), Some("gold-satin"));
    assert_eq!(give(shapes[1]), first);
    // One that was edited since is another material.
    let inner = materials_inside(&world, first.0)[0];
    world.entity_mut(inner).insert(Material::Null);
    let mut give = |shape: Entity| {
        let mut edit = Edit::begin(&mut world);
        use_preset(&mut edit, &preset, &[shape]).expect("a shape");
        edit.finish("Preset".to_owned(), None);
        world.get::<UsesMaterial>(shape).map(|used| used.0)
    };
    assert_ne!(give(shapes[2]), Some(first.0));
}

#[test]
fn a_material_of_its_own_stays_when_it_is_taken_out() {
    let mut world = world();
    let own = world.spawn((red(), DocumentOrder(1))).id();
    let outer = world
        .spawn((Material::TwoSided, DocumentOrder(2), FirstNested(own)))
        .id();
    apply(&mut world, outer, &MaterialTree::from(Material::Null));
    assert_eq!(materials(&mut world), 2);
    assert!(materials_inside(&world, outer).is_empty());
}
