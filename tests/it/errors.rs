//! Tests the kind and the source of the error for each fault.
use crate::common;

use std::{
    error::Error as _,
    fs,
    io::{self, ErrorKind},
};

use common::folder::Folder;
use stereotrace::{
    Error, Limits, Method, Scene, SkyMap, StereoCamera,
    glam::Vec3,
    metrics::compare,
    output::{Picture, save_ids_pfm, save_pfm},
};

/// Returns the error of a result. Its message must begin with the file and end with the text of its source.
#[track_caller]
fn refused<T>(file: &std::path::Path, result: Result<T, Error>) -> Error {
    let Err(error) = result else { panic!("{}: not refused", file.display()) };
    let message = error.to_string();
    assert!(message.starts_with(&file.display().to_string()), "{message}");
    let source = error.source().map(ToString::to_string).unwrap_or_default();
    assert!(message.contains(source.trim_start_matches("invalid camera: ")), "{message} does not say: {source}");
    error
}

fn io_kind(error: &Error) -> Option<ErrorKind> {
    let Error::Io { source, .. } = error else { return None };
    Some(source.kind())
}

#[test]
fn what_the_system_or_the_kind_of_a_file_forbids_is_an_io_error_with_its_path() {
    let folder = Folder::new("errors_io");
    let missing = folder.file("none.obj");
    assert_eq!(io_kind(&refused(&missing, Scene::from_obj(&missing))), Some(ErrorKind::NotFound));
    let inner = folder.file("folder");
    fs::create_dir(&inner).unwrap();
    let error = refused(&inner, Scene::from_obj(&inner));
    assert_eq!(io_kind(&error), Some(ErrorKind::IsADirectory));
    assert!(error.source().is_some_and(|source| source.is::<io::Error>()));
    // Content that the file's format can't hold gives an error and leaves no file.
    let path = folder.file("out");
    let no_pixels = Picture::new(0, 0, Vec::new()).save_png(&path);
    for result in [save_pfm(&path, 2, 2, &[1.0]), save_ids_pfm(&path, 1, 1, &[1 << 25]), no_pixels] {
        assert_eq!(io_kind(&refused(&path, result)), Some(ErrorKind::InvalidInput));
    }
    assert!(!path.exists());
}

#[test]
fn a_file_over_a_limit_says_which_limit_and_is_no_fault_of_its_content() {
    let folder = Folder::new("errors_limit");
    let obj = folder.write("scene.obj", "v 0 0 0\n");
    let error = refused(&obj, Scene::from_obj_within(&obj, &Limits::default().file_bytes(3)));
    assert!(matches!(error, Error::TooLarge { limit: 3, .. }), "{error:?}");
    let sky = folder.file("sky.png");
    image::GrayImage::new(4, 2).save(&sky).unwrap();
    let error = refused(&sky, SkyMap::open_within(&sky, &Limits::default().sky_pixels(7)));
    assert!(matches!(error, Error::TooLarge { limit: 7, .. }), "{error:?}");
    let json = folder.write("cameras.json", "{}  ");
    let error = refused(&json, StereoCamera::from_json_within(&json, "a", 1, 1, &Limits::default().json_bytes(2)));
    assert!(matches!(error, Error::TooLarge { limit: 2, .. }), "{error:?}");
}

#[test]
fn what_can_t_be_parsed_has_its_line_and_its_parser_s_own_error() {
    let folder = Folder::new("errors_parse");
    let obj = folder.write("scene.obj", "v 0 0 0\nf 1 2 3\n");
    let error = refused(&obj, Scene::from_obj(&obj));
    assert!(matches!(error, Error::Parse { line: Some(2), .. }) && error.source().is_none(), "{error:?}");

    let json = folder.write("cameras.json", "{\n\"a\": [1,,2]\n}");
    let error = refused(&json, StereoCamera::from_json(&json, "a", 1, 1));
    assert!(matches!(error, Error::Parse { line: Some(2), .. }), "{error:?}");
    assert!(error.source().is_some_and(|source| source.is::<serde_json::Error>()), "{error:?}");

    let fields = r#""eye": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0], "vfov_deg": 200, "screen_distance": 1"#;
    let json = folder.write("cameras.json", format!(r#"{{ "a": {{ {fields}, "eye_separation": 0 }} }}"#));
    let error = StereoCamera::from_json(&json, "a", 4, 4).unwrap_err();
    assert!(matches!(error, Error::Parse { line: None, .. }), "{error:?}");
    let beneath = error.source().and_then(|source| source.downcast_ref::<Error>());
    assert!(matches!(beneath, Some(Error::Camera { field: "vertical_fov", .. })), "{error:?}");

    let sky = folder.write("sky.png", "no picture");
    let error = refused(&sky, SkyMap::open(&sky));
    assert!(error.source().is_some_and(|source| source.is::<image::ImageError>()), "{error:?}");
}

#[test]
fn views_of_different_sizes_are_no_fault_of_a_camera() {
    let scene = Scene::new();
    let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO);
    let [small, large] = [4, 8].map(|side| common::render(&scene, &camera.size(side, side), Method::Naive));
    let error = compare(&small.right, &large.right, &large.pose).unwrap_err();
    assert!(matches!(error, Error::Sizes { .. }), "{error:?}");
}
