//! Tests pictures: where they are stored, how they are placed on surfaces, and how their alpha is used.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::{Value, json};
use stereotrace::{
    Finish, Limits, Material, Method, MissingTextures, Options, OutsideFiles, Scene, SceneFile, SceneOptions,
    StereoCamera, TextureId, TextureKind, Wrap,
    blocking::Wait,
    glam::{Vec2, Vec3, Vec4},
};

use super::{
    assert_near,
    common::{folder::Folder, renderer, warnings},
    gltf::{Builder, data_uri},
    material, open_with, scene,
};

fn png(width: u32, height: u32, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgba8).unwrap();
    bytes
}

/// Returns a triangle whose base colour is a texture of these pixels, with further fields of its material.
fn textured(pixels: &[[u8; 4]], more: Value) -> Builder {
    let mut builder = Builder::triangle(more);
    let texture = builder.texture(&png(pixels.len() as u32, 1, pixels));
    builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    if builder.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"].is_null() {
        builder.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0);
    }
    builder
}

fn alphas(scene: &Scene, material: &Material) -> Vec<u8> {
    match scene.textures()[material.cutout.unwrap().0 as usize].kind() {
        TextureKind::Image { pixels, .. } => pixels.iter().map(|pixel| pixel[3]).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn pictures_are_read_from_views_data_and_files_beside() {
    let folder = Folder::new("gltf_pictures");
    let bytes = png(2, 1, &[[1, 2, 3, 255], [4, 5, 6, 255]]);
    folder.write("the pictures/a+b.png", &bytes);
    let mut builder = textured(&[[0; 4]], json!({}));
    for image in [
        json!({ "bufferView": builder.view(&bytes) }),
        json!({ "uri": data_uri(&bytes) }),
        json!({ "uri": data_uri(&bytes).replace('=', "") }),
        json!({ "uri": "the%20pictures/a+b.png" }),
        json!({ "uri": "the pictures\\a+b.png" }),
    ] {
        builder.json["images"] = json!([image]);
        let scene = Scene::from_gltf(folder.write("scene.gltf", builder.text())).unwrap();
        let texture = &scene.textures()[material(&scene).texture.unwrap().0 as usize];
        let TextureKind::Image { size: [2, 1], pixels } = texture.kind() else { panic!("{texture:?}") };
        assert_eq!(pixels[1], [4, 5, 6, 255]);
    }
}

#[test]
fn buffers_and_pictures_outside_the_scenes_folder_are_refused_unless_the_option_allows_them() {
    let folder = Folder::new("gltf_outside");
    warnings::collect();
    let picture = png(1, 1, &[[1, 2, 3, 255]]);
    let mut builder = textured(&[[0; 4]], json!({}));
    let bytes = builder.bytes.clone();
    folder.write("a b.png", &picture);
    folder.write("a.bin", &bytes);
    folder.write("in/a.png", &picture);
    folder.write("in/a.bin", &bytes);
    let allow = SceneOptions::default().outside_files(OutsideFiles::Allow);
    let absolute = folder.file("a.bin").display().to_string();
    for (buffer, image, fault) in [
        ("a.bin", "a.png", None),
        ("../in/a.bin", "x/../a.png", None),
        ("../a.bin", "a.png", Some("scene.gltf: buffers[0]: ")),
        ("%2e%2e/a.bin", "a.png", Some("scene.gltf: buffers[0]: ")),
        ("a.bin", "../a%20b.png", Some("materials[0], baseColorTexture: images[0]: ")),
        ("a.bin", "..\\a b.png", Some("materials[0], baseColorTexture: images[0]: ")),
        // These are absolute paths. All but one belong to other machines. Files beside the scene replace all of them.
        ("C:/models/a.bin", "C:\\textures\\a.png", None),
        (&absolute, "/nowhere/a.png", None),
    ] {
        std::fs::create_dir_all(folder.file("in/x")).unwrap();
        builder.json["buffers"] = json!([{ "byteLength": bytes.len(), "uri": buffer }]);
        builder.json["images"] = json!([{ "uri": image }]);
        let path = folder.write("in/scene.gltf", serde_json::to_string(&builder.json).unwrap());
        assert!(SceneFile::open(&path, &allow).is_ok(), "{buffer} {image}");
        match (SceneFile::open(&path, &SceneOptions::default()), fault) {
            (Ok(file), None) => assert_eq!(file.scene.textures().len(), 1),
            (Err(error), Some(fault)) => {
                let message = error.to_string();
                let says = [fault, "outside the scene's folder ", "use SceneOptions::outside_files"];
                assert!(says.iter().all(|text| message.contains(text)), "{message}");
            }
            (found, _) => panic!("{buffer} {image}: {found:?}"),
        }
    }
    let warned = warnings::of(&folder);
    let of_elsewhere = warned.iter().filter(|text| text.contains("a path of another machine")).count();
    assert_eq!(of_elsewhere, 4, "once a file that is read: {warned:?}");
}

#[test]
fn pictures_that_can_not_be_read_are_an_error_or_a_warning() {
    let folder = Folder::new("gltf_lost");
    warnings::collect();
    let mut builder = textured(&[[9; 4]], json!({}));
    for (image, expected) in [
        (json!({ "uri": "none.png" }), "materials[0], baseColorTexture: "),
        (json!({ "uri": "scene.gltf" }), "baseColorTexture: can't read the texture: it is not PNG"),
        (json!({ "bufferView": 0 }), "baseColorTexture: can't read the texture: it is not PNG"),
        (json!({}), "images[0] has no URI and no bufferView"),
    ] {
        builder.json["images"] = json!([image]);
        let path = folder.write("scene.gltf", builder.text());
        let message = Scene::from_gltf(&path).unwrap_err().to_string();
        assert!(message.contains("scene.gltf: ") && message.contains(expected), "{message}");
        let warn = SceneOptions::default().missing_textures(MissingTextures::Warn);
        let scene = Scene::from_gltf_with(&path, &warn).unwrap();
        assert_eq!(material(&scene).texture, None);
        assert!(warnings::of(&folder).last().unwrap().contains("the material is rendered without it"));
    }
    builder.json["textures"] = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    let message = Scene::from_gltf(folder.write("scene.gltf", builder.text())).unwrap_err().to_string();
    assert!(message.contains("baseColorTexture: it has no picture of a supported type"), "{message}");
    let folder = Folder::new("gltf_pixels");
    let path = folder.write("scene.gltf", textured(&[[9; 4]; 10], json!({})).text());
    let limits = Limits::default().texture_pixels(9).texture_option_name("--max-textures");
    let message = Scene::from_gltf_with(path, &SceneOptions::default().limits(limits)).unwrap_err().to_string();
    assert!(message.contains("10x1 pixels, 10 in all, over the limit of 9; raise it with --max-textures"), "{message}");
}

/// Tests a texture with a PNG picture and, by the extension, a WebP picture.
#[test]
fn webp_pictures_of_the_extension_are_read_with_the_feature() {
    let mut builder = textured(&[[1, 2, 3, 255]], json!({}));
    builder.push("images", json!({ "uri": "gone.webp" }));
    builder.json["textures"][0]["extensions"] = json!({ "EXT_texture_webp": { "source": 1 } });
    builder.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    let folder = Folder::new("gltf_webp");
    let read = |builder: &Builder| Scene::from_gltf(folder.write("scene.gltf", builder.text()));
    let first = |scene: Scene| match scene.textures()[0].kind() {
        TextureKind::Image { pixels, .. } => pixels[0],
        other => panic!("{other:?}"),
    };
    #[cfg(not(feature = "more-textures"))]
    {
        assert_eq!(first(read(&builder).unwrap()), [1, 2, 3, 255]);
        builder.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
        assert!(read(&builder).unwrap_err().to_string().contains("it requires EXT_texture_webp"));
    }
    #[cfg(feature = "more-textures")]
    {
        builder.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
        assert!(read(&builder).unwrap_err().to_string().contains("gone.webp: "));
        let mut webp = Vec::new();
        let encoder = image::codecs::webp::WebPEncoder::new_lossless(&mut webp);
        encoder.write_image(&[9, 8, 7, 255], 1, 1, ExtendedColorType::Rgba8).unwrap();
        folder.write("gone.webp", webp);
        assert_eq!(first(read(&builder).unwrap()), [9, 8, 7, 255]);
        builder.json["textures"][0].as_object_mut().unwrap().remove("source");
        assert_eq!(first(read(&builder).unwrap()), [9, 8, 7, 255]);
        builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = json!(-1);
        let message = read(&builder).unwrap_err().to_string();
        assert!(message.contains("scene.gltf: invalid EXT_texture_webp textures: "), "{message}");
        builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = json!(7);
        assert!(read(&builder).unwrap_err().to_string().contains("there is no images[7]; the list has length 2"));
    }
}

#[test]
fn samplers_and_transforms_say_how_pictures_lie() {
    for (wrap, expected) in [(10497, Wrap::Repeat), (33071, Wrap::Clamp), (33648, Wrap::Mirror)] {
        let mut builder = textured(&[[9; 4]], json!({}));
        builder.push("samplers", json!({ "wrapS": wrap, "wrapT": wrap }));
        builder.json["textures"][0]["sampler"] = json!(0);
        assert_eq!(scene(builder.text()).textures()[0].wrap, expected);
    }
    let mut builder = textured(&[[9; 4]], json!({}));
    let second = builder.floats(&[[0.0f32, 0.0], [0.25, 0.0], [0.0, 0.5]]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_2"] = json!(second);
    let info = &mut builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info["extensions"] = json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "scale": [2, 4], "texCoord": 2,
        "rotation": std::f32::consts::FRAC_PI_2 } });
    let scene = scene(builder.text());
    // By the specification's shader, the transform is translation * rotation * scale, with v down. A quarter turn takes
    // u to -v and v to u.
    for (found, expected) in scene.uv()[0].iter().zip([[0.5f32, 0.25], [0.5, -0.25], [2.5, 0.25]]) {
        let expected = Vec2::new(expected[0], 1.0 - expected[1]);
        assert!((*found - expected).length() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn masks_cut_out_from_their_cutoff_on() {
    let pixels: Vec<[u8; 4]> = [0, 50, 102, 103, 127, 128, 255].map(|alpha| [9, 9, 9, alpha]).into();
    let read = |mode: &str, cutoff: Option<f32>, factor: f32| {
        let mut builder = textured(&pixels, json!({ "alphaMode": mode }));
        builder.json["materials"][0]["alphaCutoff"] = json!(cutoff.unwrap_or(0.5));
        builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, factor]);
        let scene = scene(builder.text());
        let material = material(&scene).clone();
        (scene, material)
    };
    // The library cuts out at an alpha of a half, so no copy of the picture is made.
    let (scene, half) = read("MASK", None, 1.0);
    assert_eq!((half.cutout, scene.textures().len(), half.opacity), (half.texture, 1, 1.0));
    let (scene, low) = read("MASK", Some(0.4), 1.0);
    assert_eq!(alphas(&scene, &low), [0, 0, 255, 255, 255, 255, 255]);
    assert_eq!(scene.textures().len(), 2);
    let (scene, darker) = read("MASK", Some(0.4), 0.7);
    assert_eq!(alphas(&scene, &darker), [0, 0, 0, 0, 0, 0, 255]);
    assert_eq!(read("MASK", Some(0.9), 0.5).1.opacity, 0.0);
    assert_eq!(read("MASK", Some(0.0), 1.0).1.cutout, None);
    let (_, opaque) = read("OPAQUE", None, 0.3);
    assert_eq!((opaque.cutout, opaque.opacity), (None, 1.0));
    // The texture's alpha blends, but for what it leaves out.
    let (scene, veil) = read("BLEND", None, 0.5);
    assert_eq!((veil.opacity, veil.alpha_blend), (0.5, true));
    assert_eq!(alphas(&scene, &veil), [0, 255, 255, 255, 255, 255, 255]);
    let thin = textured(&[[9, 9, 9, 51], [9, 9, 9, 102]], json!({ "alphaMode": "BLEND" }));
    let scene = self::scene(thin.text());
    let thin = material(&scene);
    assert_eq!((thin.opacity, thin.alpha_blend, thin.cutout), (1.0, true, None));
    // Leaves have few texels that are partly clear, and are cut out below a half.
    let mut leaves = vec![[9, 9, 9, 255]; 8];
    leaves.extend([[9, 9, 9, 0], [9, 9, 9, 100]]);
    let leaves = self::scene(textured(&leaves, json!({ "alphaMode": "BLEND" })).text());
    let leaves = material(&leaves);
    assert_eq!((leaves.opacity, leaves.alpha_blend, leaves.cutout), (1.0, false, leaves.texture));
}

#[test]
fn direct_light_shows_the_means_of_metal_roughness_and_emission_and_paths_their_pictures() {
    let mut builder = textured(
        &[[255, 0, 0, 255], [0, 0, 0, 255]],
        json!({ "emissiveFactor": [1, 1, 1],
        "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 1 } }),
    );
    // Roughness is the green channel and metal the blue channel, both linear. Emission is in sRGB.
    let texture = builder.texture(&png(2, 1, &[[9, 255, 0, 255], [9, 0, 255, 255]]));
    builder.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({ "index": texture });
    let glow = builder.texture(&png(2, 1, &[[188, 0, 0, 255], [188, 255, 0, 255]]));
    builder.json["materials"][0]["emissiveTexture"] = json!({ "index": glow });
    let clear = builder.texture(&png(2, 1, &[[51, 0, 0, 255], [153, 0, 0, 255]]));
    builder.json["materials"][0]["extensions"]["KHR_materials_transmission"] =
        json!({ "transmissionFactor": 0.5, "transmissionTexture": { "index": clear } });
    let clear = scene(builder.binary());
    let found = material(&clear).principled.unwrap();
    assert!(found.transmission == 0.5 && clear.textures()[found.transmission_texture.unwrap().0 as usize].data);
    let Finish::Glass { transmission, .. } = material(&clear).finish else { panic!("{found:?}") };
    assert_near(transmission, Vec3::splat(0.5 * 0.5 * 0.4));
    builder.json["materials"][0]["extensions"] = json!({});
    let scene = scene(builder.binary());
    let found = material(&scene);
    // The means of metal and roughness are a half. Highlights use the mean of the base colour, which is half of red.
    assert_near(found.albedo, Vec3::splat(0.5 * 0.98 + 0.25));
    assert_near(found.specular, 0.5 * (0.5 * Vec3::splat(0.04) + 0.5 * Vec3::new(0.5, 0.0, 0.0)));
    assert!((found.emission - Vec3::new(0.502_886, 0.5, 0.0)).length() < 1e-5, "{}", found.emission);
    let surface = found.principled.unwrap();
    assert_eq!((surface.base, surface.metallic, surface.roughness, surface.emission), (Vec3::ONE, 1.0, 1.0, Vec3::ONE));
    let is_data = |texture: Option<TextureId>| scene.textures()[texture.unwrap().0 as usize].data;
    assert!(
        surface.roughness_texture == surface.metallic_texture
            && is_data(surface.metallic_texture)
            && !is_data(surface.emission_texture)
    );
    assert_eq!(scene.textures().len(), 3);
}

/// A factor is linear, and a picture is in sRGB. The byte 188 equals the factor 0.5029.
#[test]
fn a_pixel_of_188_shows_what_a_factor_of_its_light_shows() {
    let dielectric = |factor: f32| {
        let color = json!([factor, factor, factor, 1]);
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorFactor": color } })
    };
    let mut shown = Vec::new();
    for builder in [textured(&[[188, 188, 188, 255]], dielectric(1.0)), Builder::triangle(dielectric(0.502_886))] {
        let scene = scene(builder.text());
        let camera = StereoCamera::look_at(Vec3::new(0.25, 0.25, 0.5), Vec3::new(0.25, 0.25, 0.0)).size(8, 8);
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        shown.push(
            renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap().left.rgba8,
        );
    }
    // Without lights, ambient light is 1. So the pictures show the texture's value of 188. Half floats have 11 bits of
    // precision.
    assert!(shown.iter().flatten().all(|pixel| pixel[0].abs_diff(188) <= 1), "{:?}", &shown[0][..4]);
    assert_eq!(shown[0].len(), 64);
}

#[test]
fn a_scene_file_of_textures_opens_by_its_content() {
    let folder = Folder::new("gltf_name");
    let path = folder.write("no ending", textured(&[[9; 4]], json!({})).binary());
    assert_eq!(SceneFile::open(path, &SceneOptions::default()).unwrap().scene.textures().len(), 1);
}

/// Adds a triangle for each of these materials, and a texture for each of these images.
fn of_materials(builder: &mut Builder, images: &[Value], materials: &[Value]) {
    builder.json["images"] = json!(images);
    builder.json["textures"] = (0..images.len()).map(|image| json!({ "source": image })).collect();
    let mut primitive = builder.json["meshes"][0]["primitives"][0].clone();
    builder.json["materials"] = json!(materials);
    builder.json["meshes"][0]["primitives"] = (0..materials.len())
        .map(|material| {
            primitive["material"] = json!(material);
            primitive.clone()
        })
        .collect();
}

fn base_color(texture: usize) -> Value {
    json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
}

#[test]
fn images_of_the_same_bytes_or_file_are_one_picture() {
    let folder = Folder::new("gltf_same_pictures");
    let [inside, beside] = [[[1, 2, 3, 255]; 2], [[4, 5, 6, 255]; 2]].map(|pixels| png(2, 1, &pixels));
    folder.write("a.png", &beside);
    let mut builder = Builder::triangle(json!({}));
    let view = builder.view(&inside);
    let again = builder.json["bufferViews"][view].clone();
    let again = builder.push("bufferViews", again);
    let images = [
        json!({ "bufferView": view }),
        json!({ "bufferView": again }),
        json!({ "uri": "a.png" }),
        json!({ "uri": "./a.png" }),
        json!({ "bufferView": view }),
    ];
    of_materials(&mut builder, &images, &(0..5).map(base_color).collect::<Vec<_>>());
    let path = folder.write("scene.gltf", builder.text());
    let limits = Limits::default().texture_pixels(4);
    let scene = Scene::from_gltf_with(path, &SceneOptions::default().limits(limits)).unwrap();
    let textures = scene.triangles().iter().map(|triangle| scene.materials()[triangle.material.0 as usize].texture);
    let textures: Vec<u32> = textures.map(|texture| texture.unwrap().0).collect();
    assert_eq!((textures, scene.textures().len()), (vec![0, 0, 1, 1, 0], 2));
}

#[test]
fn pictures_of_metal_and_roughness_have_a_limit_together() {
    let pictures: Vec<Vec<u8>> = (0..5).map(|index| png(2, 2, &[[index; 4]; 4])).collect();
    let read = |images: &[usize], cut: usize| {
        let mut builder = Builder::triangle(json!({}));
        let views: Vec<usize> = pictures.iter().map(|picture| builder.view(&picture[..picture.len() - cut])).collect();
        let images: Vec<Value> = images.iter().map(|&index| json!({ "bufferView": views[index] })).collect();
        let material =
            |texture| json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": texture } } });
        let materials: Vec<Value> = (0..images.len()).map(material).collect();
        of_materials(&mut builder, &images, &materials);
        let limits = Limits::default().texture_pixels(4).texture_option_name("--max-textures");
        let missing = if cut > 0 { MissingTextures::Warn } else { MissingTextures::Error };
        let folder = Folder::new("gltf_means");
        warnings::collect();
        let options = SceneOptions::default().limits(limits).missing_textures(missing);
        let read = SceneFile::open(folder.write("scene.gltf", builder.text()), &options);
        (read.map(|_| ()).map_err(|error| error.to_string()), warnings::of(&folder))
    };
    // The limit allows one picture. It may be used any number of times.
    assert_eq!(read(&[0, 0, 0], 0).0, Ok(()));
    let message = read(&[0, 0, 1], 0).0.unwrap_err();
    let expected = "materials[2], metallicRoughnessTexture: the picture has 2x2 pixels, 4 in all, over the limit of 0";
    assert!(message.contains(expected), "{message}");
    // Broken pictures count too, once each: sixteen pixels may be decoded, which are four pictures.
    let (_, warnings) = read(&[0, 1, 2, 3, 4], 20);
    assert!(
        warnings[3].contains("can't read the texture") && warnings[4].contains("over the limit of 0"),
        "{warnings:?}"
    );
    let (_, warnings) = read(&[0, 0, 0, 0, 0], 20);
    assert!(warnings[4].contains("materials[4]") && warnings[4].contains("can't read the texture"), "{warnings:?}");
}

#[test]
fn masks_of_one_picture_are_as_many_as_its_alphas_part_and_have_a_limit_with_it() {
    let pixels: Vec<[u8; 4]> = [0, 60, 100, 255].map(|alpha| [9, 9, 9, alpha]).into();
    let read = |cutoffs: &[f32], limit: u64| {
        let mut builder = Builder::triangle(json!({}));
        let view = builder.view(&png(4, 1, &pixels));
        let mask = |cutoff: &f32| {
            let mut material = base_color(0);
            (material["alphaMode"], material["alphaCutoff"]) = (json!("MASK"), json!(cutoff));
            material
        };
        let masks: Vec<Value> = cutoffs.iter().map(mask).collect();
        of_materials(&mut builder, &[json!({ "bufferView": view })], &masks);
        let limits = Limits::default().texture_pixels(limit).texture_option_name("--max-textures");
        open_with(builder.text(), &SceneOptions::default().limits(limits)).map(|file| file.scene)
    };
    // Cut-offs that cut out the same pixels share a texture. There are three groups: alphas from 101 to 255, from 61 to
    // 100, and from 1 to 60.
    let cutoffs: Vec<f32> = (1..=255).map(|alpha| alpha as f32 / 255.0).collect();
    let scene = read(&cutoffs, 12).unwrap();
    assert_eq!(scene.textures().len(), 3);
    let alphas = [59, 60, 99, 100, 254].map(|index| alphas(&scene, &scene.materials()[1 + index]));
    let expected = [[0, 255, 255, 255], [0, 0, 255, 255], [0, 0, 255, 255], [0, 60, 100, 255], [0, 60, 100, 255]];
    assert_eq!(alphas, expected.map(Vec::from));
    let message = read(&cutoffs, 11).unwrap_err().to_string();
    let expected = "alphaCutoff: the cut-out copy of its picture has another 4x1 pixels, 4 in all, over the limit of \
                    3; raise it with --max-textures";
    assert!(message.contains("materials[60], ") && message.contains(expected), "{message}");
}

#[test]
fn tangents_of_files_are_used_and_others_are_computed() {
    let quad = |tangent: Option<[f32; 4]>, turned: bool| {
        let mut builder = Builder::new();
        let uv = builder.floats(&[[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        let mut attributes = json!({ "TEXCOORD_0": uv });
        if let Some(tangent) = tangent {
            attributes["TANGENT"] = json!(builder.floats(&[tangent; 4]));
        }
        let indices = builder.indices(&[0, 1, 2, 0, 2, 3]);
        let positions = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let mesh = builder.mesh(&positions, json!({ "attributes": attributes, "indices": indices, "material": 0 }));
        let texture = builder.texture(&png(1, 1, &[[128, 128, 255, 255]]));
        let mut info = json!({ "index": texture });
        if turned {
            builder.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
            info["extensions"] = json!({ "KHR_texture_transform": { "rotation": std::f32::consts::FRAC_PI_2 } });
        }
        builder.push("materials", json!({ "normalTexture": info }));
        builder.node(json!({ "mesh": mesh, "scale": [-1, 1, 1] }));
        scene(builder.text()).tangents()[0]
    };
    let all = |tangent: Vec4| [tangent; 3];
    let near = |found: [Vec4; 3], expected: Vec4| {
        assert!(found.iter().zip(all(expected)).all(|(a, b)| a.distance(b) < 1e-6), "{found:?} is not {expected}");
    };
    // The node mirrors the mesh, and with it the direction of u; v still grows upwards.
    near(quad(Some([0.6, 0.8, 0.0, 1.0]), false), Vec4::new(-0.6, 0.8, 0.0, -1.0));
    near(quad(None, false), Vec4::new(-1.0, 0.0, 0.0, -1.0));
    // Tangents belong to coordinates without a transform. A quarter turn takes u to where v grew.
    near(quad(Some([0.6, 0.8, 0.0, 1.0]), true), Vec4::new(0.0, -1.0, 0.0, -1.0));
}

#[test]
fn clear_coats_and_transforms_of_normal_textures_are_read() {
    let mut builder = textured(&[[9; 4]], json!({}));
    let coat = builder.texture(&png(1, 1, &[[128, 64, 9, 255]]));
    let transform = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
    let info = json!({ "index": coat, "extensions": transform });
    builder.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_texture_transform"]);
    builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform.clone();
    builder.json["materials"][0]["normalTexture"] = info.clone();
    builder.json["materials"][0]["extensions"] = json!({
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatTexture": info,
            "clearcoatRoughnessFactor": 0.25, "clearcoatRoughnessTexture": { "index": coat } },
        "KHR_materials_specular": { "specularFactor": 0.25, "specularColorFactor": [1, 0.5, 0] },
    });
    let surface = material(&scene(builder.text())).principled.unwrap();
    assert!(surface.normal_texture.is_some() && surface.clearcoat_texture == surface.normal_texture);
    // The roughness has another map, so the mean of its green is used.
    assert_eq!((surface.clearcoat, surface.clearcoat_roughness_texture), (0.5, None));
    assert!((surface.clearcoat_roughness - 0.25 * 64.0 / 255.0).abs() < 1e-6, "{}", surface.clearcoat_roughness);
    assert_eq!((surface.specular, surface.grazing), (Vec3::new(0.25, 0.125, 0.0), 0.25));
    // A normal texture with another map is left out.
    builder.json["materials"][0]["normalTexture"] = json!({ "index": coat });
    assert_eq!(material(&scene(builder.text())).principled.unwrap().normal_texture, None);
}
