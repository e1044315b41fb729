//! Tests files that an OBJ or MTL names outside the scene's folder, and absolute paths of other machines.

use std::{fs, path::Path};

use image::{Rgb, RgbImage};
use stereotrace::{Error, MissingTextures, OutsideFiles, Scene, SceneOptions};

use super::{SIX, common};

fn triangle(library: &str) -> String {
    format!("mtllib {library}\n{SIX}vt 1 2\nusemtl a\nf 1/1 2/1 3/1\n")
}

fn picture(path: &Path) {
    RgbImage::from_pixel(1, 1, Rgb([9, 9, 9])).save_with_format(path, image::ImageFormat::Png).unwrap();
}

/// Makes a folder with a scene in `in/`, and a picture and an MTL beside `in/`.
fn outside(name: &str) -> common::folder::Folder {
    common::warnings::collect();
    let folder = common::folder::Folder::new(name);
    fs::create_dir_all(folder.file("in/sub")).unwrap();
    folder.write("out.mtl", "newmtl a\nKd 0 1 0\n");
    picture(&folder.file("out.png"));
    picture(&folder.file("in/own.png"));
    folder.write("in/scene.obj", triangle("sub/m.mtl"));
    folder
}

fn allow() -> SceneOptions {
    SceneOptions::default().outside_files(OutsideFiles::Allow)
}

#[test]
fn textures_outside_the_scenes_folder_are_refused_unless_the_option_allows_them() {
    let folder = outside("outside_textures");
    let scene = folder.file("in/scene.obj");
    let absolute = folder.file("out.png").display().to_string();
    for (name, is_outside) in [
        ("../../out.png", true),
        ("..\\..\\out.png", true),
        ("../sub/.././../out.png", true),
        (&*absolute, true),
        ("../own.png", false),
        ("../../in/own.png", false),
    ] {
        folder.write("in/sub/m.mtl", format!("newmtl a\nmap_Kd {name}\n"));
        assert_eq!(Scene::from_obj_with(&scene, &allow()).unwrap().textures().len(), 1, "{name}");
        let found = Scene::from_obj(&scene);
        if !is_outside {
            assert_eq!(found.unwrap().textures().len(), 1, "{name}");
            continue;
        }
        let message = found.unwrap_err().to_string();
        let real = folder.path().canonicalize().unwrap();
        let says = [
            format!("m.mtl:2: map_Kd '{name}' of material 'a': it is {}", real.join("out.png").display()),
            format!("outside the scene's folder {}", real.join("in").display()),
            "to read it, use SceneOptions::outside_files(OutsideFiles::Allow)".into(),
        ];
        assert!(says.iter().all(|text| message.contains(text)), "{message}");
        let named = SceneOptions::default().outside_option_name("--outside-files allow");
        let message = Scene::from_obj_with(&scene, &named).unwrap_err().to_string();
        assert!(message.ends_with("to read it, use --outside-files allow"), "{message}");
        // Like other unreadable textures, they give a warning if that option is set.
        let warn = SceneOptions::default().missing_textures(MissingTextures::Warn);
        assert_eq!(Scene::from_obj_with(&scene, &warn).unwrap().textures().len(), 0);
        let warned = common::warnings::of(&folder);
        assert!(warned.iter().any(|text| text.contains("outside the scene's folder")), "{warned:?}");
    }
}

#[test]
fn mtl_files_outside_are_errors_and_those_that_are_not_there_stay_warnings() {
    let folder = outside("outside_mtl");
    let absolute = folder.file("out.mtl").display().to_string();
    for name in ["../out.mtl", "none.mtl ../out.mtl", &absolute] {
        let scene = folder.write("in/scene.obj", triangle(name));
        let error = Scene::from_obj(&scene).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::Parse { line: Some(1), source: Some(_), .. }), "{message}");
        let expected = format!("scene.obj:1: mtllib '{name}': it is ");
        assert!(message.contains(&expected) && message.contains("outside_files"), "{message}");
        let read = Scene::from_obj_with(&scene, &allow()).unwrap();
        assert!(read.materials().iter().any(|material| material.name == "a"), "{name}");
    }
    for name in ["../none.mtl", "/nowhere/none.mtl"] {
        assert!(Scene::from_obj(folder.write("in/scene.obj", triangle(name))).is_ok(), "{name}");
    }
}

#[test]
fn absolute_paths_of_other_machines_fall_back_to_the_files_name_and_this_is_said_once() {
    let folder = outside("elsewhere");
    picture(&folder.file("in/sub/near.png"));
    let obj = format!("{}usemtl b\nf 1/1 2/1 3/1\n", triangle("C:\\models\\my house\\m.mtl"));
    let scene = folder.write("in/scene.obj", obj);
    let read = |first: &str, second: &str| {
        folder.write("in/m.mtl", format!("newmtl a\nmap_Kd {first}\nnewmtl b\nmap_Kd {second}\n"));
        Scene::from_obj(&scene)
    };
    let before = common::warnings::of(&folder).len();
    let found = read("C:\\textures\\own.png", "-clamp on D:/tex/own.png").unwrap();
    assert_eq!(found.textures().len(), 2);
    let warned = common::warnings::of(&folder).split_off(before);
    assert_eq!(warned.len(), 1, "{warned:?}");
    let expected = "it names 'C:\\models\\my house\\m.mtl', a path of another machine; ";
    assert!(warned[0].contains(expected) && warned[0].contains("m.mtl is read"), "{warned:?}");
    // A file at the absolute path but outside the folder is also replaced by a file beside the scene.
    picture(&folder.file("own.png"));
    let absolute = folder.file("own.png").display().to_string();
    assert_eq!(read(&absolute, "\\\\server\\share\\own.png").unwrap().textures().len(), 1);
    // Relative paths keep their folders.
    let message = read("C:\\textures\\own.png", "lost\\own.png").unwrap_err().to_string();
    assert!(message.contains("map_Kd 'lost\\own.png' of material 'b': "), "{message}");
    let message = read("C:\\textures\\lost.png", "own.png").unwrap_err().to_string();
    assert!(message.contains("map_Kd 'C:\\textures\\lost.png' of material 'a': "), "{message}");
    // For an MTL in another folder, a file beside the MTL comes before a file beside the scene.
    folder.write("in/scene.obj", triangle("sub/m.mtl"));
    for name in ["near.png", "own.png"] {
        folder.write("in/sub/m.mtl", format!("newmtl a\nmap_Kd E:\\{name}\n"));
        assert_eq!(Scene::from_obj(&scene).unwrap().textures().len(), 1, "{name}");
    }
}

#[cfg(unix)]
#[test]
fn links_count_by_where_they_lead() {
    use std::os::unix::fs::symlink;

    let folder = outside("links");
    let linked = |name: &str| {
        folder.write("in/sub/m.mtl", format!("newmtl a\nmap_Kd {name}\n"));
        Scene::from_obj(folder.file("in/scene.obj")).map(|scene| scene.textures().len())
    };
    // One link leads to a file outside the scene's folder, one to a folder outside, and one to a file inside.
    symlink(folder.file("out.png"), folder.file("in/sub/out.png")).unwrap();
    symlink("../..", folder.file("in/sub/up")).unwrap();
    symlink("../own.png", folder.file("in/sub/own.png")).unwrap();
    for name in ["out.png", "up/out.png"] {
        let message = linked(name).unwrap_err().to_string();
        assert!(message.contains("outside the scene's folder"), "{name}: {message}");
    }
    assert_eq!(linked("own.png").unwrap(), 1);
    assert_eq!(linked("up/in/own.png").unwrap(), 1);
    // Files in a linked folder count as inside, by either name of the folder.
    symlink("in", folder.file("way")).unwrap();
    let real = folder.file("in/own.png").canonicalize().unwrap().display().to_string();
    for name in ["../own.png", "../../way/own.png", "../../in/own.png", &real] {
        folder.write("in/sub/m.mtl", format!("newmtl a\nmap_Kd {name}\n"));
        assert_eq!(Scene::from_obj(folder.file("way/scene.obj")).unwrap().textures().len(), 1, "{name}");
    }
    // If the scene file is a link, its folder is the folder of the link.
    fs::create_dir(folder.file("other")).unwrap();
    symlink("../in/scene.obj", folder.file("other/scene.obj")).unwrap();
    let scene = Scene::from_obj(folder.file("other/scene.obj")).unwrap();
    assert_eq!(scene.textures().len(), 0, "there is no sub/m.mtl beside the link");
    symlink("../in/sub", folder.file("other/sub")).unwrap();
    let message = Scene::from_obj(folder.file("other/scene.obj")).unwrap_err().to_string();
    assert!(message.contains("mtllib 'sub/m.mtl': it is ") && message.contains("outside"), "{message}");
    assert_eq!(Scene::from_obj_with(folder.file("other/scene.obj"), &allow()).unwrap().textures().len(), 1);
}
