//! Tests the fields of MTL materials other than the diffuse colour.

use stereotrace::{Finish, Material, Scene, blocking::Wait, glam::Vec3};

use super::{Folder, SIX, common, material};

fn read(folder: &Folder, mtl: &str) -> Scene {
    folder.write("m.mtl", mtl);
    folder.scene(format!("mtllib m.mtl\n{SIX}f 1 2 3\n"))
}

#[test]
fn values_are_taken_as_they_stand_and_have_defaults() {
    let folder = Folder::new("values");
    let mtl = "newmtl all\nKd 0.1 0.2 0.3\nKs 0.4 0.5 0.6 # shiny\nNs 96.5\nKe 15 0 2\nd 0.25\nillum 2\nnewmtl none\n";
    let scene = read(&folder, mtl);
    let all = material(&scene, "all");
    assert_eq!((all.albedo, all.specular), (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.4, 0.5, 0.6)));
    assert_eq!((all.exponent, all.emission, all.opacity), (96.5, Vec3::new(15.0, 0.0, 2.0), 0.25));
    assert_eq!((all.finish, all.texture, all.cutout), (Finish::Matte, None, None));
    let none = material(&scene, "none");
    assert_eq!(*none, Material::new(Vec3::splat(0.7)).name("none"));
    assert_eq!((none.specular, none.exponent, none.opacity), (Vec3::ZERO, 30.0, 1.0));
}

#[test]
fn illumination_models_say_what_a_surface_does() {
    let folder = Folder::new("illum");
    let glass = |index, through: f32, fresnel| Finish::Glass { index, transmission: Vec3::splat(through), fresnel };
    let mirror = |fresnel| Finish::Mirror { fresnel };
    let highlight = Vec3::splat(0.5);
    let cases = [
        ("", Finish::Matte, highlight),
        ("illum 0", Finish::Matte, Vec3::ZERO),
        ("illum 1", Finish::Matte, Vec3::ZERO),
        ("illum 2", Finish::Matte, highlight),
        ("illum 3", mirror(false), highlight),
        ("illum 5", mirror(true), highlight),
        ("illum 8", mirror(false), highlight),
        ("illum 6", glass(1.5, 1.0, false), highlight),
        ("illum 7\nNi 1.33", glass(1.33, 1.0, true), highlight),
        ("illum 9\nTf 0.5", glass(1.5, 0.5, false), highlight),
        ("illum 7\nd 0.25\nTf 0.5", glass(1.5, 0.375, true), highlight),
        // Maya writes model 4 for all materials.
        ("illum 4\nTf 1 1 1\nNi 1", Finish::Matte, highlight),
        ("illum 4\nd 0.5", glass(1.5, 0.5, false), highlight),
        ("illum 4\nTf 0.75", glass(1.5, 0.75, false), highlight),
        ("illum 4\nKd 0 0 0", glass(1.5, 1.0, false), highlight),
        ("illum 10", Finish::Matte, highlight),
    ];
    let text = |(index, (lines, ..)): (usize, &(&str, Finish, Vec3))| {
        // The diffuse part is small enough that no material returns more light than it receives.
        let diffuse = if lines.contains("illum 4\nTf 1") || lines.contains("illum 4\nd") { 0.25 } else { 0.01 };
        let diffuse = if lines.contains("illum 6") || lines.contains("illum 7\nNi") { 0.0 } else { diffuse };
        format!("newmtl m{index}\nKd {diffuse} 0 0\nKs 0.5 0.5 0.5\n{lines}\n")
    };
    let scene = read(&folder, &cases.iter().enumerate().map(text).collect::<String>());
    for (index, (lines, finish, specular)) in cases.into_iter().enumerate() {
        let found = material(&scene, &format!("m{index}"));
        assert_eq!((found.finish, found.specular), (finish, specular), "{lines}");
        assert!(found.opacity == 1.0, "{lines}");
    }
    // A renderer must accept the materials of every file.
    common::renderer().upload(&scene).wait().unwrap();
}

#[test]
fn a_mirror_without_a_specular_colour_reflects_all() {
    let folder = Folder::new("white_mirror");
    let mtl = "newmtl absent\nKd 0 0 0\nillum 3\nnewmtl black\nKd 0 0 0\nKs 0 0 0\nillum 3\n";
    let scene = read(&folder, mtl);
    assert_eq!(["absent", "black"].map(|name| material(&scene, name).specular), [Vec3::ONE, Vec3::ZERO]);
    common::renderer().upload(&scene).wait().unwrap();
}

#[test]
fn of_d_and_tr_the_first_holds_wherever_it_stands() {
    let folder = Folder::new("opacity");
    let mtl = "newmtl tr\nTr 0.75\nnewmtl both\nTr 1\nd 1\nnewmtl other\nd 0.5\nTr 0.25\nnewmtl halo\nd -halo 0.125\n\
               newmtl unseen\nTr 1\nnewmtl d\nd 0\n";
    let scene = read(&folder, mtl);
    let opacities = ["tr", "both", "other", "halo", "unseen", "d"].map(|name| material(&scene, name).opacity);
    assert_eq!(opacities, [0.25, 1.0, 0.5, 0.125, 0.0, 0.0]);
    let expected =
        "m.mtl:11: material 'unseen' is invisible, because its Tr is 1; if it should be opaque, give it a d of 1";
    let warnings = folder.warnings();
    assert_eq!(warnings.iter().filter(|text| text.contains("invisible")).collect::<Vec<_>>(), [expected]);
}

#[test]
fn values_that_are_none_are_left_out_with_their_line() {
    let folder = Folder::new("bad_values");
    for line in [
        "Ks red",
        "Ke 1 nan 0",
        "Tf 1 2",
        "Ns",
        "Ns inf",
        "Ni two",
        "d NaN",
        "d -halo",
        "Tr 1 2",
        "illum 11",
        "illum x",
    ] {
        let scene = read(&folder, &format!("newmtl odd\nKd 0.5 0.5 0.5\n{line}\n"));
        assert_eq!(*material(&scene, "odd"), Material::new(Vec3::splat(0.5)).name("odd"), "{line}");
        let keyword = line.split(' ').next().unwrap();
        let rest = line[keyword.len()..].trim();
        let expected = format!("m.mtl:3: {keyword} '{rest}' of material 'odd' is not a");
        let warnings = folder.warnings();
        assert!(
            warnings.iter().any(|text| text.starts_with(&expected) && text.ends_with("it is ignored")),
            "{warnings:?}"
        );
    }
    read(&folder, "Ns 3\nnewmtl a\n");
    assert!(folder.warnings().contains(&"m.mtl:1: Ns before the first newmtl; it is ignored".into()));
}

#[test]
fn values_out_of_range_are_brought_into_it_with_one_warning_a_file() {
    let folder = Folder::new("ranges");
    let mtl = "newmtl bright\nKd 2 0 0\nKs 0 -1 3\nKe -1 2 0\nNs 1e9\nd 1.5\nnewmtl glass\nKd 0 0 0\nNi 0\nTf 2 1 \
        0\nillum 7\n\
               newmtl mirror\nKd 0.5 0.25 0\nKs 1.5 0.75 0\nillum 3\nnewmtl phong\nKd 0.9 0.9 0.9\nKs 0.9 0.9 \
                   0.9\nillum 2\n";
    let scene = read(&folder, mtl);
    let bright = material(&scene, "bright");
    assert_eq!((bright.albedo, bright.specular, bright.emission), (Vec3::X, Vec3::Z, Vec3::Y * 2.0));
    assert_eq!((bright.exponent, bright.opacity), (10_000.0, 1.0));
    let transmission = Vec3::new(1.0, 1.0, 0.0);
    assert_eq!(material(&scene, "glass").finish, Finish::Glass { index: 0.1, transmission, fresnel: true });
    // Materials that would reflect more than they receive are darkened as a whole. Highlights don't count as
    // reflections.
    let mirror = material(&scene, "mirror");
    assert_eq!(mirror.albedo, Vec3::new(0.5, 0.25, 0.0) / 1.5);
    assert_eq!(mirror.specular, Vec3::new(1.0, 0.75, 0.0) / 1.5);
    assert_eq!(material(&scene, "phong").specular, Vec3::splat(0.9));
    let warnings = folder.warnings();
    let ranges: Vec<_> = warnings.iter().filter(|text| text.contains("out of range")).collect();
    assert_eq!(ranges, ["m.mtl: values out of range, which are clamped, in 3 materials"]);
    common::renderer().upload(&scene).wait().unwrap();
}
