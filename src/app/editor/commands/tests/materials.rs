//! Commands about materials.

use super::*;
use crate::app::editor::command::{
    EditCommand, HistoryCommand, MaterialEdit, OutlineEdit, SceneEdit, SelectionCommand, ValueEdit,
};
use crate::app::editor::model::EditorModel;
use crate::scene::{Medium, PhaseFunction};

#[test]
fn a_new_material_belongs_to_its_shape() {
    let mut world = bare_world();
    let shape = world.spawn(crate::scene::Shape::default()).id();
    say(&mut world, MaterialEdit::GiveMaterial { shape });
    let used = world.get::<UsesMaterial>(shape).map(|uses| uses.0);
    assert!(used.is_some_and(|material| world.get::<Material>(material).is_some()));
    say(
        &mut world,
        MaterialEdit::UseMaterial {
            shapes: vec![shape],
            material: None,
        },
    );
    assert!(world.get::<UsesMaterial>(shape).is_none());
}

#[test]
fn a_material_of_its_own_begins_as_a_copy_and_is_named_after_a_preset() {
    let mut world = bare_world();
    let presets = crate::app::editor::command::presets::built_in();
    world.resource_mut::<EditorModel>().0.presets = presets.into();
    let [one, two] = [0; 2].map(|_| add(&mut world, AdditionKind::Cube));
    let red = Material::Diffuse {
        reflectance: Rgb::X.into(),
    };
    let wood = world.spawn((red.clone(), DocumentOrder(0), Name::new("wood"))).id();
    world.entity_mut(wood).insert(SceneId("wood".to_owned()));
    let (shapes, material) = (vec![one, two], Some(wood));
    say(&mut world, MaterialEdit::UseMaterial { shapes, material });
    say(&mut world, MaterialEdit::GiveMaterial { shape: one });
    let own = world.get::<UsesMaterial>(one).expect("a material").0;
    assert_eq!(world.get::<Material>(own), Some(&red));
    assert_eq!(world.get::<UsesMaterial>(two), Some(&UsesMaterial(wood)));
    let choose = |world: &mut World, path: &str| {
        let presets = world.resource::<EditorModel>().0.presets.clone();
        let preset = presets.iter().find(|preset| preset.path() == path).expect(path);
        let (targets, tree) = (vec![own], Box::new(preset.tree.clone()));
        say(world, MaterialEdit::BuildMaterial { targets, tree });
        world.get::<SceneId>(own).expect("an id").0.clone()
    };
    assert_eq!(world.get::<SceneId>(own).map(|id| id.0.as_str()), Some("wood-2"));
    assert_eq!(choose(&mut world, "Metal/copper"), "copper");
    assert_eq!(choose(&mut world, "Metal/gold"), "gold");
    say(&mut world, OutlineEdit::Rename(own, "handle".to_owned()));
    assert_eq!(choose(&mut world, "Metal/copper"), "handle");
}

#[test]
fn the_history_says_which_material_a_thing_got() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    say(&mut world, MaterialEdit::GiveMaterial { shape: ball });
    let paint = world.get::<UsesMaterial>(ball).map(|uses| uses.0).expect("a material");
    say(&mut world, OutlineEdit::Rename(paint, "paint".into()));
    for material in [None, Some(paint)] {
        let shapes = vec![ball];
        say(&mut world, MaterialEdit::UseMaterial { shapes, material });
    }
    let (done, _) = world.resource::<History>().labels();
    assert_eq!(
        done[done.len() - 2..],
        ["Assign material `sphere`: none", "Assign material `sphere`: paint"]
    );
}

#[test]
fn a_deleted_material_comes_back_to_its_shapes() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    say(&mut world, MaterialEdit::GiveMaterial { shape: ball });
    let material = world.get::<UsesMaterial>(ball).map(|uses| uses.0).expect("a material");
    say(&mut world, SelectionCommand::Select(vec![material], Extend::Replace));
    say(&mut world, SceneEdit::Delete);
    assert!(world.get::<UsesMaterial>(ball).is_none() && world.get::<Material>(material).is_none());
    let messages: Vec<&str> = world.resource::<Toasts>().texts().collect();
    assert_eq!(messages, ["sphere has no material now"]);
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(world.get::<UsesMaterial>(ball).map(|uses| uses.0), Some(material));
    assert!(world.get::<Material>(material).is_some());
}

#[test]
fn materials_within_others_are_edited_together() {
    let mut world = bare_world();
    let shapes = [0; 2].map(|_| add(&mut world, AdditionKind::Cube));
    let tree = MaterialTree::from(Material::default()).wrapped("twosided");
    let inner = shapes.map(|shape| {
        let targets = vec![shape];
        let tree = Box::new(tree.clone());
        say(&mut world, MaterialEdit::BuildMaterial { targets, tree });
        let whole = world.get::<UsesMaterial>(shape).expect("a material").0;
        world.get::<FirstNested>(whole).expect("a material inside").0
    });
    say(&mut world, SelectionCommand::Select(shapes.to_vec(), Extend::Replace));
    let glass = Material::of_plugin("plastic").expect("a plugin");
    let edit = ValueEdit::SetMaterial(inner[0], Box::new(glass.clone()));
    say(&mut world, EditCommand::OnSelection(Box::new(edit)));
    assert_eq!(
        inner.map(|inner| world.get::<Material>(inner) == Some(&glass)),
        [true; 2]
    );
}

#[test]
fn what_refracts_does_not_come_inside_of_two_sides() {
    let mut world = bare_world();
    let ball = add(&mut world, AdditionKind::Sphere);
    let build = |target, tree: MaterialTree| {
        Command::from(MaterialEdit::BuildMaterial {
            targets: vec![target],
            tree: Box::new(tree),
        })
    };
    let grey = MaterialTree::from(Material::default());
    say(&mut world, build(ball, grey.wrapped("twosided")));
    let outer = world.get::<UsesMaterial>(ball).expect("a material").0;
    let inner = world.get::<FirstNested>(outer).expect("a material inside").0;
    let glass = Material::of_plugin("dielectric").expect("a plugin");
    let wrong = [
        build(inner, glass.clone().into()),
        Command::from(ValueEdit::SetMaterial(inner, Box::new(glass.clone()))),
        build(ball, MaterialTree::from(glass.clone()).wrapped("twosided")),
    ];
    for command in wrong {
        let steps = world.resource::<History>().len();
        let error = apply(&mut world, command)
            .expect_err("no file could hold it")
            .to_string();
        assert!(error.contains("two sides already"), "{error}");
        assert_eq!(world.get::<Material>(inner), Some(&Material::default()));
        assert_eq!(world.resource::<History>().len(), steps);
    }
    say(&mut world, build(ball, glass.clone().into()));
    assert_eq!(world.get::<Material>(outer), Some(&glass));
}

#[test]
fn a_change_of_a_medium_is_called_by_its_parameter() {
    let mut world = bare_world();
    let name = Name::new("fog");
    let medium = world.spawn((Medium::default(), DocumentOrder(0), name)).id();
    let mut denser = Medium {
        scale: 2.0,
        ..Medium::default()
    };
    say(&mut world, ValueEdit::SetMedium(medium, Box::new(denser.clone())));
    world.resource_mut::<Requests>().interaction += 1;
    denser.phase = PhaseFunction::HenyeyGreenstein { g: 0.5 };
    say(&mut world, ValueEdit::SetMedium(medium, Box::new(denser)));
    let (done, _) = world.resource::<History>().labels();
    assert_eq!(done, ["Edit medium `fog`: Density", "Edit medium `fog`: Phase"]);
}
