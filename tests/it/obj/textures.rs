//! Tests textures that an MTL names: which files are read, and the messages about unreadable ones.

use image::{Rgb, RgbImage, Rgba, RgbaImage};
use stereotrace::{
    Error, Limits, MissingTextures, Scene, SceneOptions, Texture, TextureId, TextureKind, Wrap,
    glam::{Vec2, Vec3},
};

use super::{Folder, SIX, material};
use crate::common::scenes_with;

/// Returns an OBJ with a triangle of each material, with texture coordinates (1, 2).
fn obj(materials: &[&str]) -> String {
    let faces: String = materials.iter().map(|name| format!("usemtl {name}\nf 1/1 2/1 3/1\n")).collect();
    format!("mtllib sub/m.mtl\n{SIX}vt 1 2\n{faces}")
}

fn red(folder: &Folder, name: &str) {
    folder.write(name, []);
    RgbImage::from_pixel(2, 1, Rgb([255, 0, 0])).save_with_format(folder.file(name), image::ImageFormat::Png).unwrap();
}

fn pixels(texture: &Texture) -> &[[u8; 4]] {
    match texture.kind() {
        TextureKind::Image { pixels, .. } => pixels,
        other => panic!("{other:?}"),
    }
}

fn warn() -> SceneOptions {
    SceneOptions::default().missing_textures(MissingTextures::Warn)
}

#[test]
fn a_file_of_several_materials_and_spellings_is_one_texture() {
    let folder = Folder::new("shared");
    red(&folder, "sub/a.png");
    red(&folder, "sub/deep/with space.png");
    folder.write(
        "sub/m.mtl",
        "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd a.png\nnewmtl b\nmap_Kd   ./a.png  \nnewmtl c\nmap_Kd deep/../a.png\nnewmtl \
        d\n\
         map_Kd deep\\with space.png\nnewmtl e\nKd 0 0 0\nmap_Kd a.png\n",
    );
    let scene = folder.scene(obj(&["a", "b", "c", "d", "e"]));
    let ids = ["a", "b", "c", "d", "e"].map(|name| material(&scene, name).texture.unwrap().0);
    assert_eq!(ids, [0, 0, 0, 1, 0]);
    assert_eq!(scene.textures().len(), 2);
    assert_eq!(pixels(&scene.textures()[0]), [[255, 0, 0, 255]; 2]);
    // The texture is multiplied by the given colour. Without a colour, or with one that would hide the texture, white
    // is used.
    let albedos = ["a", "b", "e"].map(|name| material(&scene, name).albedo);
    assert_eq!(albedos, [Vec3::splat(0.5), Vec3::ONE, Vec3::ONE]);
    let black = "sub/m.mtl:10: material 'e' has a texture and a black Kd; white is used instead";
    assert!(folder.warnings().iter().any(|text| text == black), "{:?}", folder.warnings());
}

#[test]
fn options_before_the_name_are_taken_or_skipped() {
    let folder = Folder::new("options");
    red(&folder, "sub/a b.png");
    red(&folder, "sub/-odd 1.png");
    red(&folder, "sub/7");
    let cases = [
        ("a b.png", Wrap::Repeat, [1.0, 2.0]),
        ("-clamp on a b.png", Wrap::Clamp, [1.0, 2.0]),
        ("-clamp off a b.png", Wrap::Repeat, [1.0, 2.0]),
        ("-s 2 3 1 -o 0.5 a b.png", Wrap::Repeat, [2.5, 6.0]),
        ("-o 0.5 0.25 0 -s 2 a b.png", Wrap::Repeat, [2.5, 2.25]),
        ("-blendu on -blendv off -bm 0.5 -boost 2 -texres 512 -type sphere a b.png", Wrap::Repeat, [1.0, 2.0]),
        ("-mm 0 1 -t 0.1 0.1 -cc on -imfchan m a b.png", Wrap::Repeat, [1.0, 2.0]),
        ("-odd 1.png", Wrap::Repeat, [1.0, 2.0]),
        ("-s 2 7", Wrap::Repeat, [2.0, 2.0]),
    ];
    for (words, wrap, uv) in cases {
        folder.write("sub/m.mtl", format!("newmtl a\nmap_Kd {words}\n"));
        let scene = folder.scene(obj(&["a"]));
        assert_eq!(scene.textures()[0].wrap, wrap, "{words}");
        assert_eq!(scene.uv(), [[Vec2::from(uv); 3]], "{words}");
    }
    // The clamped and the repeated texture of one file share the pixels.
    folder.write("sub/m.mtl", "newmtl a\nmap_Kd a b.png\nnewmtl b\nmap_Kd -clamp on a b.png\n");
    let scene = folder.scene(obj(&["a", "b"]));
    let [first, second] = scene.textures() else { panic!("{:?}", scene.textures()) };
    assert!(std::ptr::eq(pixels(first), pixels(second)));
    folder.write("sub/m.mtl", "newmtl a\nmap_Kd -clamp on\nmap_d\n");
    assert_eq!(folder.scene(obj(&["a"])).textures().len(), 0);
    let warnings = folder.warnings();
    assert!(
        warnings.iter().any(|text| text.starts_with("sub/m.mtl:3: map_d '' of material 'a' is not a file")),
        "{warnings:?}"
    );
}

/// Returns the header of a PNG with a side of 100,000 pixels.
fn huge() -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = png::Encoder::new(&mut bytes, 100_000, 100_000);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[]).unwrap();
    bytes
}

#[test]
fn textures_that_can_not_be_read_are_errors_with_line_and_name_or_warnings() {
    let folder = Folder::new("unreadable");
    folder.write("sub/huge.png", huge()).write("sub/text.png", "no picture").write("sub/cut.png", &huge()[..20]);
    folder.write("sub/folder/file", "");
    let cases = [
        ("gone.png", if cfg!(unix) { "No such file" } else { "" }),
        ("no such name.png", ""),
        ("huge.png", "100000x100000 pixels; each side can have 1 to 8192"),
        ("text.png", "it is not PNG"),
        ("cut.png", "can't read the texture"),
        ("folder", "it is a folder; only regular files are read"),
        ("m.mtl", "it is the MTL file itself"),
        ("../sub/m.mtl", "it is the MTL file itself"),
        ("../scene.obj", "it is the OBJ file itself"),
    ];
    for keyword in ["map_Kd", "map_d"] {
        for (name, reason) in cases {
            folder.write("sub/m.mtl", format!("newmtl a\nKd 0.5 0.5 0.5\n{keyword} {name}\n"));
            let error = folder.read(obj(&["a"])).unwrap_err();
            let message = error.to_string();
            let Error::Parse { path, line: Some(3), source: Some(_), .. } = error else { panic!("{message}") };
            assert_eq!(path, folder.file("sub/m.mtl"));
            let expected = format!("m.mtl:3: {keyword} '{name}' of material 'a': ");
            assert!(message.contains(&expected) && message.contains(reason), "{expected}{reason}: {message}");

            let scene = folder.read_with(obj(&["a"]), &warn()).unwrap();
            let found = material(&scene, "a");
            assert_eq!((found.texture, found.cutout, found.albedo), (None, None, Vec3::splat(0.5)));
            let warnings = folder.warnings();
            let said =
                |text: &String| text.contains(&expected) && text.ends_with("; the material is rendered without it");
            assert!(warnings.iter().any(said), "{expected}: {warnings:?}");
        }
    }
    // No texture is read for a material that no face uses.
    assert!(folder.read(obj(&["b"])).is_ok());
}

#[test]
fn all_textures_together_have_a_limit() {
    let folder = Folder::new("texture_limit");
    red(&folder, "sub/a.png");
    red(&folder, "sub/b.png");
    folder.write("sub/m.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nmap_Kd a.png\n");
    let options = |pixels| SceneOptions::default().limits(Limits::default().texture_pixels(pixels));
    assert_eq!(folder.read_with(obj(&["a", "b", "c"]), &options(4)).unwrap().textures().len(), 2);
    let message = folder.read_with(obj(&["a", "b", "c"]), &options(3)).unwrap_err().to_string();
    let expected = "m.mtl:4: map_Kd 'b.png' of material 'b': the picture has 2x1 pixels, 2 in all, over the limit of 1";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn cutouts_are_alpha_and_brightness_where_there_is_none() {
    let folder = Folder::new("cutout");
    let mut leaf = RgbaImage::from_pixel(2, 1, Rgba([10, 20, 30, 255]));
    leaf.put_pixel(1, 0, Rgba([1, 2, 3, 0]));
    folder.write("sub/leaf.png", []);
    leaf.save(folder.file("sub/leaf.png")).unwrap();
    let mut mask = RgbImage::from_pixel(2, 1, Rgb([255, 255, 255]));
    mask.put_pixel(1, 0, Rgb([0, 100, 0]));
    mask.save(folder.file("sub/mask.png")).unwrap();
    folder.write(
        "sub/m.mtl",
        "newmtl a\nmap_Kd leaf.png\nmap_d leaf.png\nnewmtl b\nmap_Kd mask.png\nmap_d mask.png\nnewmtl c\nmap_d -s 2 \
        mask.png\n\
         newmtl d\nmap_Kd leaf.png\nmap_d -s 3 mask.png\n",
    );
    let scene = folder.scene(obj(&["a", "b", "c", "d"]));
    let ids = ["a", "b", "c"].map(|name| (material(&scene, name).texture, material(&scene, name).cutout));
    let id = |index| Some(TextureId(index));
    assert_eq!(ids, [(id(0), id(0)), (id(1), id(2)), (None, id(2))]);
    assert_eq!(pixels(&scene.textures()[0]), [[10, 20, 30, 255], [1, 2, 3, 0]]);
    assert_eq!(pixels(&scene.textures()[1]), [[255; 4], [0, 100, 0, 255]]);
    assert_eq!(pixels(&scene.textures()[2]), [[255; 4], [0, 100, 0, 72]]);
    assert_eq!(scene.uv()[2..], [[Vec2::new(2.0, 2.0); 3], [Vec2::new(1.0, 2.0); 3]]);
    let other = "sub/m.mtl:11: material 'd' has different -s or -o for map_d and map_Kd; those of map_Kd are used";
    assert!(folder.warnings().iter().any(|text| text.starts_with(other)), "{:?}", folder.warnings());
}

/// Writes an MTL with two materials for each picture, which name the picture by this statement. Returns an OBJ that
/// uses the materials.
fn twice(folder: &Folder, pictures: &[&str], statement: &str) -> String {
    let names = pictures.iter().flat_map(|name| [format!("{name}1"), format!("{name}2")]);
    let names: Vec<String> = names.collect();
    let mtl: String =
        names.iter().map(|name| format!("newmtl {name}\n{statement} {}.png\n", &name[..name.len() - 1])).collect();
    folder.write("sub/m.mtl", mtl);
    obj(&names.iter().map(|name| &**name).collect::<Vec<_>>())
}

#[test]
fn masks_of_brightness_and_broken_pictures_have_a_limit_with_the_others() {
    let folder = Folder::new("mask_limit");
    let limits = |pixels| Limits::default().texture_pixels(pixels).texture_option_name("--max-textures");
    red(&folder, "sub/a.png");
    let content = twice(&folder, &["a"], "map_d");
    let read = |pixels| folder.read_with(&content, &SceneOptions::default().limits(limits(pixels)));
    assert_eq!(read(4).unwrap().textures().len(), 1);
    let message = read(3).unwrap_err().to_string();
    let expected = "m.mtl:2: map_d 'a.png' of material 'a1': its copy with brightness as alpha has another 2x1 pixels, \
                    2 in all, over the limit of 1; raise it with --max-textures";
    assert!(message.contains(expected), "{message}");
    // Each broken picture is decoded once, even if several statements name it. In total, up to four times the limit may
    // be decoded.
    let broken = std::fs::read(folder.file("sub/a.png")).unwrap();
    let names = ["b", "c", "d", "e", "f"];
    for name in names {
        folder.write(&format!("sub/{name}.png"), &broken[..broken.len() - 20]);
    }
    let content = twice(&folder, &names, "map_Kd");
    assert!(folder.read_with(content, &warn().limits(limits(2))).is_ok());
    let warnings = folder.warnings();
    let said = |text: &str| warnings.iter().filter(|warning| warning.contains(text)).count();
    // The first five of ten warnings are logged: two for each of the first two pictures, and one for the third.
    assert_eq!((said("can't read the texture"), said("textures that can't be read: 5 more")), (5, 1), "{warnings:?}");
}

/// Returns a scene from `STEREOTRACE_SCENES` or target/scenes, if it is there.
fn found(name: &str) -> Option<Scene> {
    let file = format!("{name}/{name}.obj");
    Some(Scene::from_obj(scenes_with(&file)?.join(file)).unwrap())
}

#[test]
fn the_cow_and_the_atrium_come_with_their_textures() {
    for (name, count) in [("spot", 1), ("sponza", 10)] {
        let Some(scene) = found(name) else { continue };
        assert_eq!(scene.textures().len(), count, "{name}");
        assert_eq!(scene.uv().len(), scene.triangles().len(), "{name}");
        for texture in scene.textures() {
            assert!(matches!(texture.kind(), TextureKind::Image { size: [512, 512], .. }), "{texture:?}");
            let mean = pixels(texture).iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / (512.0 * 512.0);
            assert!(mean > 20.0 && mean < 250.0, "{name}: {mean}");
        }
        let used = |triangle: &stereotrace::Triangle| scene.materials()[triangle.material.0 as usize].texture.is_some();
        let share =
            scene.triangles().iter().filter(|triangle| used(triangle)).count() as f32 / scene.triangles().len() as f32;
        println!("{name}: {share} of the triangles have a texture");
        assert!(share > 0.5, "{name}: {share}");
    }
}
