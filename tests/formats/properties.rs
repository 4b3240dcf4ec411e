//! Properties of things and of the scene: `default`s with a type in the file.

use std::path::Path;

use sunroom::document::{self, parse_str};
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, save_description, write_anew};
use sunroom::scene::{Properties, PropertyType, PropertyValue, SceneDescription};

const SCENE: &str = r#"<scene version="3.0.0">
  <default name="gravity: number" value="9.81"/>
  <sensor type="perspective" id="eye">
    <default name="player: integer" value="1"/>
  </sensor>
  <shape type="sphere" id="coin">
    <default name="value:integer" value="05"/> <!-- five -->
    <float name="radius" value="0.5"/>
    <default name="colours: color list" value="1, 0.5, 0; #ffffff"/>
    <default name="game::Spin: component" value='{"speed": 1.5}'/>
  </shape>
  <shape type="shapegroup" id="tree">
    <default name="species: text" value="oak"/>
    <shape type="cube" id="trunk"><default name="hollow: boolean" value="true"/></shape>
  </shape>
  <shape type="instance"><ref id="tree"/><default name="height: number" value="3"/></shape>
  <emitter type="point"><default name="switch: reference" value="coin"/></emitter>
  <bsdf type="diffuse" id="wood"><default name="step: file" value="sounds/wood.ogg"/></bsdf>
</scene>
"#;

fn value(kind: &str, text: &str) -> Option<PropertyValue> {
    Some(PropertyType::of_name(kind)?.parse(text).unwrap())
}

fn described(path: &Path) -> SceneDescription {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    assert!(document.diagnostics.list.is_empty(), "{}", document.diagnostics);
    scene
}

/// The properties of all things, in the order of lists.
fn all(scene: &SceneDescription) -> Vec<Option<Properties>> {
    let shapes = scene.shapes.iter().map(|it| &it.identity);
    let others = scene.emitters.iter().map(|it| &it.identity);
    let sensors = scene.sensors.iter().map(|it| &it.identity);
    let groups = scene.groups.iter().map(|it| &it.identity);
    let materials = scene.materials.iter().map(|it| &it.identity);
    let all = shapes.chain(others).chain(sensors).chain(groups).chain(materials);
    all.map(|identity| identity.properties.clone()).collect()
}

#[test]
fn properties_are_read_saved_and_written_anew() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.xml");
    std::fs::write(&main, SCENE).unwrap();
    let scene = described(&main);
    let coin = scene.shapes[0].identity.properties.clone().unwrap();
    assert_eq!(coin.get("value").cloned(), value("integer", "5"));
    assert_eq!(coin.get("colours").cloned(), value("color list", "1, 0.5, 0; 1"));
    assert_eq!(coin.get("game::Spin").cloned(), value("component", "{\"speed\": 1.5}"));
    assert_eq!(scene.properties.0.get("gravity").cloned(), value("number", "9.81"));
    let count = all(&scene)
        .iter()
        .flatten()
        .map(|own| own.iter().count())
        .sum::<usize>();
    assert_eq!(count, 3 + 1 + 1 + 1 + 1 + 1 + 1);

    // What nobody touched stays to the byte.
    save_description(&scene, &main).unwrap();
    assert_eq!(std::fs::read_to_string(&main).unwrap(), SCENE);
    for extensions in [Extensions::Keep, Extensions::Approximate] {
        let anew = folder.path().join("anew.xml");
        write_anew(&scene, &anew, extensions).unwrap();
        let again = described(&anew);
        assert_eq!(all(&again), all(&scene));
        assert_eq!(again.properties, scene.properties);
    }
}

#[test]
fn an_edited_property_changes_its_line_alone() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.xml");
    std::fs::write(&main, SCENE).unwrap();
    let mut scene = described(&main);
    let own = &mut scene.shapes[0].identity.properties;
    let coin = own.clone().unwrap();
    let coin = coin.with("value", value("integer", "7")).with("game::Spin", None);
    *own = coin.with("says", value("text", "a \"b\" <c> & $d; it's")).some();
    scene.properties.0 = scene
        .properties
        .0
        .with("gravity", None)
        .with("night", value("boolean", "true"));
    save_description(&scene, &main).unwrap();
    let text = std::fs::read_to_string(&main).unwrap();
    let expected = SCENE.replace("value=\"05\"/> <!--", "value=\"7\"/> <!--").replace(
        "    <default name=\"game::Spin: component\" value='{\"speed\": 1.5}'/>\n",
        "    <default name=\"says: text\" value='a \"b\" &lt;c&gt; &amp; \\$d; it&apos;s'/>\n",
    );
    assert!(
        text.contains("  <default name=\"night: boolean\" value=\"true\"/>"),
        "{text}"
    );
    assert!(!text.contains("gravity"), "{text}");
    let shape = |text: &str| text[text.find("<shape").unwrap()..].to_owned();
    assert_eq!(shape(&text), shape(&expected));
    assert_eq!(all(&described(&main)), all(&scene));
}

#[test]
fn a_file_that_is_named_stays_as_it_is_in_another_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (main, other) = (folder.path().join("main.xml"), folder.path().join("other/main.xml"));
    std::fs::create_dir(folder.path().join("other")).unwrap();
    std::fs::write(&main, SCENE).unwrap();
    save_description(&described(&main), &other).unwrap();
    let scene = described(&other);
    assert_eq!(all(&scene), all(&described(&main)));
    save_description(&scene, &other).unwrap();
    assert_eq!(all(&described(&other)), all(&scene));
}

#[test]
fn a_plugin_of_this_program_alone_is_no_light_of_a_file() {
    let text = "<scene version='3.0.0'><sensor type='perspective'/>\n <emitter type='markerpoint'/></scene>";
    let mut document = parse_str(text.to_owned(), Path::new("/scene.xml"), &[]);
    let scene = read(&mut document);
    assert!(scene.emitters.is_empty(), "{:?}", scene.emitters);
}

#[test]
fn wrong_values_are_errors_with_their_places() {
    let messages = |tag: &str| {
        let text =
            format!("<scene version='3.0.0'><sensor type='perspective'/>\n <shape type='cube'>{tag}</shape></scene>");
        let mut document = parse_str(text, Path::new("/scene.xml"), &[]);
        read(&mut document);
        (document.diagnostics.has_errors(), document.diagnostics.to_string())
    };
    for (tag, expected) in [
        (
            "<default name='health: integer' value='many'/>",
            "the property `health`: expected an integer, found `many`",
        ),
        (
            "<default name='at: vector list' value='1,2,3; 1,2'/>",
            "the property `at`: expected three numbers, found `1,2`",
        ),
        (
            "<default name='health: integer' value='1'/><default name='health: number' value='1'/>",
            "the property `health` is given twice in shape `cube`",
        ),
        (
            "<default name='game::Door: component' value='(locked)'/>",
            "the property `game::Door`: expected JSON such as",
        ),
    ] {
        let (failed, text) = messages(tag);
        assert!(failed && text.contains(expected) && text.contains("2:"), "{text}");
    }
    let (failed, text) = messages("<default name='health: integr' value='1'/>");
    assert!(!failed && text.contains("did you mean `integer`?"), "{text}");
    // A plain default is what it was.
    let (failed, text) = messages("<default name='size' value='1'/><boolean name='flip_normals' value='false'/>");
    assert!(!failed && text.is_empty(), "{text}");
}
