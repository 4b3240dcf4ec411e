//! Scene files and the values in them.

use std::path::Path;

use glam::{Mat4, Vec3};
use sunroom_core::document::revision::{Destination, revise};
use sunroom_core::document::source::decode;
use sunroom_core::document::spectrum::{Role, SampledSpectrum, SpectrumError};
use sunroom_core::document::value::{
    format_float, parse_boolean, parse_float, parse_floats, parse_integer, parse_rgb, parse_srgb, parse_vec3,
    parse_vec3_or_splat,
};
use sunroom_core::document::{
    Category, Child, Document, Object, Property, Span, TransformOp, Value, WriteError, parse_str, to_xml,
};

use super::NOWHERE;

/// A scene file, native or of the imported dialect. What is read without an error is the same after it was written and
/// read again, and writing it over its own text changes nothing.
pub fn xml(bytes: &[u8]) {
    let path = Path::new(NOWHERE);
    let text = match decode(bytes.to_vec(), path) {
        Ok(text) => text,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let document = parse_str(text.as_str(), path, &[("size".to_owned(), "3".to_owned())]);
    let diagnostics = &document.diagnostics;
    // Layouting many messages would take most of the time.
    if diagnostics.list.len() <= 3 {
        diagnostics.render(false);
        let _ = diagnostics.to_string();
    }
    if diagnostics.has_errors() {
        return;
    }
    assert_survives_writing(&document);
    if !document.imported {
        let destination = Destination {
            path,
            find_before: &|_, _| None,
            find_after: &|_, _| None,
            has_changed: &|_| false,
        };
        let files = revise(&document, &document, &destination).expect("nothing is written anew");
        assert_eq!(files, [(path.to_owned(), text)], "written over itself");
    }
}

/// Writes and reads again. A file may hold control characters, which are refused when they are to be written.
pub fn assert_survives_writing(document: &Document) {
    let text = match to_xml(document) {
        Ok(text) => text,
        Err(WriteError::NotXml { .. }) => return,
        Err(error) => panic!("{error}"),
    };
    let again = parse_str(text.as_str(), &document.path, &[]);
    assert!(!again.diagnostics.has_errors(), "{}\n{text}", again.diagnostics);
    assert_eq!(without_spans(&again.root), without_spans(&document.root), "{text}");
    assert_eq!(again.search_folders, document.search_folders, "{text}");
}

/// The tree without the places in the file.
pub fn without_spans(object: &Object) -> Object {
    let properties = object.properties.iter().map(|property| Property {
        span: Span::default(),
        ..property.clone()
    });
    let children = object.children.iter().map(|child| match child {
        Child::Object(object) => without_spans(object).into(),
        Child::Reference { name, id, .. } => Child::Reference {
            name: name.clone(),
            id: id.clone(),
            span: Span::default(),
        },
    });
    Object {
        properties: properties.collect(),
        children: children.collect(),
        span: Span::default(),
        ..object.clone()
    }
}

/// A native scene with key frames: it survives being written at any moment, and then has the values of that moment.
/// Returns whether it is one that could be written.
pub fn animation(bytes: &[u8]) -> bool {
    let path = Path::new(NOWHERE);
    let Ok(text) = decode(bytes.to_vec(), path) else {
        return false;
    };
    let document = parse_str(text.as_str(), path, &[]);
    if document.imported || document.diagnostics.has_errors() {
        return false;
    }
    let Some((first, last)) = document.animated_span() else {
        return false;
    };
    assert!(first <= last && first.is_finite() && last.is_finite());
    for share in [-1.0, 0.0, 0.3, 0.5, 1.0, 2.0] {
        let time = first + (last - first) * share;
        let moment = document.at(time);
        assert_eq!(moment.animated_span(), Some((first, last)));
        let text = match to_xml(&moment) {
            Ok(text) => text,
            Err(WriteError::NotXml { .. }) => return false,
            Err(error) => panic!("at {time}: {error}"),
        };
        let again = parse_str(text.as_str(), path, &[]);
        assert!(!again.diagnostics.has_errors(), "{}\n{text}", again.diagnostics);
        // As text, in which a number that is none is the same as another: huge keys have such numbers between them,
        // which the reader of scenes refuses.
        let [found, expected] = [&again.at(time), &moment].map(|moment| format!("{:?}", without_spans(&moment.root)));
        assert_eq!(found, expected, "at {time}: {text}");
    }
    true
}

/// A list of wavelengths with values, and a file of them. What is read is what a plain reading of the text finds, and
/// its colours are those of the same spectrum given in another way.
pub fn spectra(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let is_blank = |c: char| matches!(c, ' ' | ',' | '\t' | '\n' | '\r');
    let pairs = text.split(is_blank).filter(|pair| !pair.is_empty());
    let pairs = pairs.map(|pair| {
        let colon = pair.find(':')?;
        plain_pair(&pair[..colon], &pair[colon + 1..])
    });
    assert_is_spectrum(&SampledSpectrum::parse_list(&text), pairs.collect(), &text);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let columns = lines.map(|line| line.split(is_blank).filter(|word| !word.is_empty()).collect::<Vec<_>>());
    let pairs = columns.filter(|words| !words.is_empty()).map(|words| match words[..] {
        [wavelength, value] => plain_pair(wavelength, value),
        _ => None,
    });
    assert_is_spectrum(&SampledSpectrum::parse_file(&text), pairs.collect(), &text);
}

fn plain_pair(wavelength: &str, value: &str) -> Option<[f32; 2]> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f32| number.is_finite());
    Some([number(wavelength)?, number(value)?])
}

/// `pairs` is what a plain reading has found, None if it is no spectrum.
fn assert_is_spectrum(spectrum: &Result<SampledSpectrum, SpectrumError>, pairs: Option<Vec<[f32; 2]>>, text: &str) {
    let increases = |pairs: &Vec<[f32; 2]>| pairs.len() >= 2 && pairs.windows(2).all(|two| two[0][0] < two[1][0]);
    let pairs = pairs.filter(increases);
    assert_eq!(spectrum.is_ok(), pairs.is_some(), "{text:?}");
    let (Ok(spectrum), Some(pairs)) = (spectrum, pairs) else {
        return;
    };
    let column = |place: usize| {
        let numbers: Vec<String> = pairs.iter().map(|pair| format_float(pair[place])).collect();
        numbers.join(" ")
    };
    let apart = SampledSpectrum::parse_irregular(&column(0), &column(1));
    assert_eq!(apart.as_ref(), Ok(spectrum), "{text:?}");
    for role in [Role::Emission, Role::Daylight, Role::Reflectance, Role::Unbounded] {
        let (color, _) = spectrum.to_rgb(role);
        assert!(color.is_finite() && color.min_element() >= 0.0, "{color} from {text:?}");
    }
}

/// The text of an attribute as each type of value, and the bytes as numbers to be printed. What is read is finite, and
/// a number that is printed reads back exactly.
pub fn numbers(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(number) = parse_float(&text) {
        assert_reads_back(number);
    }
    let _ = (parse_integer(&text), parse_boolean(&text));
    let triples = [parse_vec3, parse_vec3_or_splat, parse_rgb, parse_srgb].map(|parse| parse(&text));
    for triple in triples.into_iter().flatten() {
        assert!(triple.is_finite(), "{triple} from {text:?}");
    }
    if let Ok(numbers) = parse_floats(&text) {
        numbers.into_iter().for_each(assert_reads_back);
    }
    let printed = bytes.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four));
    printed.filter(|number| number.is_finite()).for_each(assert_reads_back);
}

fn assert_reads_back(number: f32) {
    let text = format_float(number);
    assert_eq!(parse_float(&text).map(f32::to_bits), Ok(number.to_bits()), "{text}");
}

/// Steps of a transform made of the bytes: they survive writing, and the map is finite where the steps are of moderate
/// size.
pub fn transforms(bytes: &[u8]) {
    let mut numbers = bytes[bytes.len().min(8)..]
        .as_chunks::<4>()
        .0
        .iter()
        .map(|four| f32::from_le_bytes(*four))
        .map(|number| if number.is_finite() { number } else { 0.0 })
        .fuse();
    let mut number = || numbers.next().unwrap_or(1.0);
    let mut steps = Vec::new();
    for kind in &bytes[..bytes.len().min(8)] {
        let mut triple = || Vec3::new(number(), number(), number());
        steps.push(match kind % 5 {
            0 => TransformOp::Translate(triple()),
            1 => TransformOp::Scale(triple()),
            2 => TransformOp::Rotate {
                axis: triple(),
                degrees: number(),
            },
            3 => {
                let mut matrix = Mat4::from_cols_array(&std::array::from_fn(|_| number()));
                for column in 0..4 {
                    matrix.col_mut(column).w = if column == 3 { 1.0 } else { 0.0 };
                }
                TransformOp::Matrix(matrix)
            }
            _ => TransformOp::LookAt {
                origin: triple(),
                target: triple(),
                // Zero counts as not given.
                up: Some(triple()).filter(|&up| up != Vec3::ZERO).unwrap_or(Vec3::Y),
            },
        });
    }
    let is_moderate = |step: &TransformOp| {
        // A rotation scales by the square of the length of its axis.
        let has_long_axis = matches!(step, TransformOp::Rotate { axis, .. } if axis.abs().max_element() > 30.0);
        let numbers = step.numbers();
        !has_long_axis && numbers.iter().all(|number| number.abs() < 1e3)
    };
    let map = TransformOp::compose(&steps);
    if steps.iter().all(is_moderate) {
        assert!(map.is_finite(), "{map} of {steps:?}");
    }
    let shape = Object::new(Category::Shape, "cube").with("to_world", Value::Transform(steps.clone()));
    let root = Object::new(Category::Scene, "").with_child(shape);
    let text = to_xml(&Document::new(NOWHERE, root)).expect("all numbers are finite");
    let again = parse_str(text.as_str(), Path::new(NOWHERE), &[]);
    // A look along its own up direction and the like are errors.
    if !again.diagnostics.has_errors() {
        let read = again.root.objects().next().map(|shape| &shape.properties[0].value);
        assert_eq!(read, Some(&Value::Transform(steps)), "{text}");
    }
}
