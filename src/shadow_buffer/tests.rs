//! Compares filled tables with brute force in plain Rust.

use crate::blocking::Wait;
use glam::{Vec2, Vec3};

use super::*;
use crate::{
    Builtin, Light, Material, MaterialId, Mesh, Method, Plane, Renderer, Scene, Sphere, StereoCamera,
    Texture as Picture, UploadedScene,
    random::Random,
    testing::cpu::{intersect::closest_hit, shadow_buffer::fill},
};

/// Tolerance of t for grazing rays, relative to t. The device rounds a texel's direction differently, since its sine
/// may differ from the host's.
const GRAZING: f32 = 1e-3;

fn renderer() -> Renderer {
    Renderer::new(Gpu::under_test())
}

impl Tables {
    /// Reads back the texels of a layer, word by word.
    async fn read(&self, gpu: &Gpu, layer: u32) -> Vec<Vec<u32>> {
        let (width, height) = (self.texture.0.width(), self.texture.0.height());
        let texel = self.texture.texel();
        let padded = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.storage_buffer("texels", u64::from(padded) * u64::from(height));
        let copy = || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let from = wgpu::TexelCopyTextureInfo {
                texture: &self.texture.0,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                aspect: wgpu::TextureAspect::All,
            };
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: Some(height) };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
            encoder.copy_texture_to_buffer(from, to, size);
            gpu.queue.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(copy).await.unwrap();
        let words: Vec<u32> = gpu.read(&buffer, (padded / 4 * height) as usize).await.unwrap();
        let Mapping { rows, columns, .. } = self.layers[layer as usize].mapping;
        let row = |row: u32| words[(row * padded / 4) as usize..].chunks((texel / 4) as usize).take(columns as usize);
        (0..rows).flat_map(row).map(<[u32]>::to_vec).collect()
    }
}

/// Returns boxes of triangles, spheres, an infinite ground and a board with every other square cut out, around the
/// origin.
fn scene(planes: bool, seed: u32) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    for _ in 0..12 {
        scene.add_sphere(Sphere::new(random.point(2.0), 0.1 + 0.05 * random.below(6) as f32, MaterialId(0))).unwrap();
    }
    let board = scene.add_texture(Picture::checkerboard(Vec3::ONE, Vec3::ZERO, 5).unwrap());
    let fence = scene.add_material(Material::new(Vec3::splat(0.4)).cutout(board));
    for index in 0..20 {
        let middle = random.point(2.5);
        let corners = std::array::from_fn::<_, 3, _>(|_| middle + random.point(0.6));
        let uv = vec![[Vec2::ZERO, Vec2::X, Vec2::Y]];
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).uv(uv);
        let mesh = if index % 4 == 0 { mesh.materials(vec![fence]) } else { mesh };
        scene.add_mesh(&mesh).unwrap();
    }
    if planes {
        scene.add_plane(Plane::new(Vec3::new(0.0, -3.0, 0.0), Vec3::new(0.1, 1.0, 0.0), MaterialId(0))).unwrap();
    }
    scene
}

fn tables_of(renderer: &Renderer, uploaded: &UploadedScene, rows: u32, rule: ShadowRule) -> Arc<Tables> {
    let options = Options::new(Method::Naive).shadow_buffer(ShadowBuffer::new(rows).rule(rule));
    pollster::block_on(uploaded.shadow_tables(&renderer.kernels, &options)).unwrap().unwrap().0
}

/// Returns the number of texels of all lights that show another primitive than brute force finds, and the number of all
/// texels. Asserts that t agrees.
fn differing(renderer: &Renderer, scene: &Scene, rows: u32, rule: ShadowRule) -> (usize, usize) {
    let uploaded = renderer.upload(scene).wait().unwrap();
    let tables = tables_of(renderer, &uploaded, rows, rule);
    let (mut differing, mut all) = (0, 0);
    for (index, layer) in tables.layers.iter().enumerate() {
        let found = pollster::block_on(tables.read(&renderer.gpu, index as u32));
        let expected = fill(scene, layer.light, &layer.mapping);
        assert_eq!(found.len(), expected.len());
        for (texel, (words, &(truth, id))) in found.iter().zip(&expected).enumerate() {
            let (t, slot) = match words[..] {
                [t, slot] => (f32::from_bits(t), slot),
                [x, y, z, slot] => {
                    let middle = [texel as u32 / layer.mapping.columns, texel as u32 % layer.mapping.columns];
                    let [row, column] = middle.map(|place| f64::from(place) + 0.5);
                    let direction = layer.mapping.direction(row, column).as_vec3();
                    let plane = Vec3::from_array([x, y, z].map(f32::from_bits));
                    // The hit on a sphere does not lie on the plane of the sphere's outline.
                    let is_flat = (id as usize) < scene.triangles().len()
                        || id as usize >= scene.triangles().len() + scene.spheres().len();
                    let t = if is_flat { 1.0 / plane.dot(direction) } else { truth };
                    (t, if slot < UNFILLED { slot & (u32::MAX >> 1) } else { slot })
                }
                _ => unreachable!(),
            };
            assert_ne!(slot, UNFILLED, "texel {texel} of light {index} was not filled");
            let found_id = if slot == crate::MISS { slot } else { uploaded.ids[slot as usize] };
            all += 1;
            if found_id != id {
                differing += 1;
            } else if id != crate::MISS {
                assert!((t - truth).abs() <= GRAZING * truth, "{t} for {truth}");
            }
        }
    }
    (differing, all)
}

#[test]
fn every_texel_has_the_nearest_hit_along_its_middle() {
    let renderer = renderer();
    for (planes, rows) in [(false, 24), (true, 17), (false, 1), (true, 2), (false, 50)] {
        let mut scene = scene(planes, 5 + rows);
        // The lights are inside the scene, at a sphere's centre, and outside the scene.
        let within = scene.spheres()[3].center;
        for position in [Vec3::new(0.1, 0.2, -0.3), within, Vec3::new(9.0, 4.0, -7.0), Vec3::new(0.0, 30.0, 0.0)] {
            scene.lights.push(Light::point(position, Vec3::ONE));
        }
        for rule in [ShadowRule::Object, ShadowRule::HYBRID] {
            let (differing, all) = differing(&renderer, &scene, rows, rule);
            // The tolerance allows for rays that pass an edge within rounding.
            assert!(differing * 500 <= all, "{rows} rows: {differing} of {all} texels");
        }
    }
}

/// Compares a sample of texels of a table that is drawn in several bands with brute force.
#[test]
fn tables_that_are_drawn_in_bands_are_whole() {
    let renderer = renderer();
    let mut scene = scene(true, 12);
    scene.lights.push(Light::point(Vec3::new(0.1, 0.2, -0.3), Vec3::ONE));
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for rule in [ShadowRule::Object, ShadowRule::HYBRID] {
        let tables = tables_of(&renderer, &uploaded, 1100, rule);
        let Layer { light, mapping, .. } = tables.layers[0];
        assert!(mapping.rows * mapping.columns > BAND);
        let texels = pollster::block_on(tables.read(&renderer.gpu, 0));
        let (mut wrong, mut all) = (0, 0);
        for (texel, words) in texels.iter().enumerate().step_by(211) {
            let [row, column] = [texel / mapping.columns as usize, texel % mapping.columns as usize];
            let direction = mapping.direction(row as f64 + 0.5, column as f64 + 0.5).as_vec3();
            let (_, id) = closest_hit(&scene, light, direction, 0.0, crate::FAR);
            let slot = words[words.len() - 1];
            let slot = if words.len() == 4 && slot < UNFILLED { slot & (u32::MAX >> 1) } else { slot };
            let found = if slot == crate::MISS { slot } else { uploaded.ids[slot as usize] };
            wrong += usize::from(found != id);
            all += 1;
        }
        assert!(all > 10_000 && wrong * 500 <= all, "{wrong} of {all}");
    }
}

/// Brute force finds nothing in front of the plane of an unmarked texel. The exception is the sphere whose outline lies
/// on the plane.
#[test]
fn nothing_stands_before_what_an_unmarked_texel_shows() {
    let renderer = renderer();
    let mut random = Random::new(77);
    let mut counts = [[0; 3]; 4];
    for (planes, rows) in [(false, 24), (true, 17), (false, 60), (true, 90)] {
        let mut scene = scene(planes, 105 + rows);
        let within = scene.spheres()[3].center;
        for position in [Vec3::new(0.1, 0.2, -0.3), within, Vec3::new(9.0, 4.0, -7.0), Vec3::new(0.0, 30.0, 0.0)] {
            scene.lights.push(Light::point(position, Vec3::ONE));
        }
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let tables = tables_of(&renderer, &uploaded, rows, ShadowRule::Hybrid { margin: 0.0 });
        for (index, Layer { light, mapping, .. }) in tables.layers.iter().enumerate() {
            let texels = pollster::block_on(tables.read(&renderer.gpu, index as u32));
            for (texel, words) in texels.iter().enumerate().filter(|(_, words)| words[3] < UNFILLED) {
                let plane = Vec3::from_array([0, 1, 2].map(|axis| f32::from_bits(words[axis]))).as_dvec3();
                let shown = uploaded.ids[(words[3] & (u32::MAX >> 1)) as usize];
                let is_marked = words[3] > u32::MAX >> 1;
                let place = [texel as u32 / mapping.columns, texel as u32 % mapping.columns].map(f64::from);
                let is_before = (0..6).any(|_| {
                    let [row, column] = place.map(|place| place + random.below(1000) as f64 / 1000.0);
                    let direction = mapping.direction(row, column);
                    let (t, id) = closest_hit(&scene, *light, direction.as_vec3(), 0.0, crate::FAR);
                    id != shown && id != crate::MISS && plane.dot(direction) * f64::from(t) < 1.0 - 1e-4
                });
                assert!(is_marked || !is_before, "light {index}, {rows} rows: texel {place:?} shows {shown}");
                for (count, is_so) in counts[index].iter_mut().zip([!is_marked, is_marked, is_marked && is_before]) {
                    *count += usize::from(is_so);
                }
            }
        }
    }
    println!(
        "texels that are not marked, that are, and of these those that were seen to be so rightly, by light: {counts:?}"
    );
    // The light inside a sphere is skipped. The sphere has no plane for it, so everything outside the sphere is marked.
    for [unmarked, marked, rightly] in [counts[0], counts[2], counts[3]] {
        assert!(unmarked > 10 * marked && 8 * rightly > marked);
    }
}

#[test]
fn a_table_is_kept_until_its_light_moves_or_the_scene_does() {
    let renderer = renderer();
    let mut scene = scene(false, 3);
    scene.lights = [Vec3::ZERO, Vec3::new(0.0, 8.0, 1.0)].map(|position| Light::point(position, Vec3::ONE)).to_vec();
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let options = Options::new(Method::Naive).shadow_buffer(ShadowBuffer::new(20));
    let filled = |uploaded: &UploadedScene, options: &Options| {
        let (tables, work) = pollster::block_on(uploaded.shadow_tables(&renderer.kernels, options)).unwrap().unwrap();
        let counts = tables.layers.iter().map(|layer| u64::from(layer.mapping.rows * layer.mapping.columns));
        (work.filled, counts.collect::<Vec<_>>())
    };
    let (all, counts) = filled(&uploaded, &options);
    assert_eq!((all, counts[0]), (counts.iter().sum(), 800));
    assert!(counts[1] < 800, "a light outside has a table of the scene's directions alone: {counts:?}");
    assert_eq!(filled(&uploaded, &options).0, 0);
    let with = |rule| options.clone().shadow_buffer(ShadowBuffer::new(20).rule(rule));
    for rule in [ShadowRule::Hybrid { margin: 0.5 }, ShadowRule::DEPTH, ShadowRule::HYBRID] {
        assert!(filled(&uploaded, &with(rule)).0 > 0, "what is marked is a matter of the margin");
    }
    let bias = ShadowRule::Depth { bias: 2.0 };
    assert!(filled(&uploaded, &with(ShadowRule::DEPTH)).0 > 0 && filled(&uploaded, &with(bias)).0 == 0);
    assert!(filled(&uploaded, &options).0 > 0);
    let before = tables_of(&renderer, &uploaded, 20, ShadowRule::HYBRID);
    scene.lights[0].position.x = 0.25;
    renderer.update(&mut uploaded, &scene, crate::Update::Refit).wait().unwrap();
    let kept = pollster::block_on(before.read(&renderer.gpu, 0));
    assert_eq!(filled(&uploaded, &options).0, 800 + counts[1], "what a frame still reads is not filled anew");
    assert!(kept == pollster::block_on(before.read(&renderer.gpu, 0)));
    drop(before);
    scene.lights[0].position.x = 0.5;
    renderer.update(&mut uploaded, &scene, crate::Update::Refit).wait().unwrap();
    assert_eq!(filled(&uploaded, &options).0, 800, "only the light that moved");
    scene.set_sphere(scene.object_of(20), Sphere::new(Vec3::X, 0.5, MaterialId(0))).unwrap();
    renderer.update(&mut uploaded, &scene, crate::Update::Refit).wait().unwrap();
    assert!(filled(&uploaded, &options).0 > 800);
}

#[test]
fn lights_that_have_no_table_are_left_out() {
    let renderer = renderer();
    let mut scene = scene(false, 4);
    let point = |index: usize| Light::point(Vec3::new(index as f32 * 0.1, 1.0, 0.0), Vec3::ONE);
    scene.lights = (0..40).map(point).collect();
    scene.lights[0] = Light::sphere(Vec3::Y, 0.5, Vec3::ONE);
    let options = Options::new(Method::Naive).shadow_buffer(ShadowBuffer::new(4));
    let reading = |scene: &Scene| renderer.upload(scene).wait().unwrap().casters().reading(&options);
    assert_eq!(reading(&scene).unwrap().lights, 0x1fffe);
    scene.lights.iter_mut().take(16).for_each(|light| *light = Light::sphere(Vec3::Y, 0.5, Vec3::ONE));
    assert_eq!(reading(&scene).unwrap().lights, 0xffff_0000);
    scene.lights[0] = Light::point(Vec3::splat(1e5), Vec3::ONE);
    assert_eq!(reading(&scene), None, "from so far off rays run from the surface");
    scene.lights.clear();
    assert_eq!(reading(&scene), None);
    let camera: StereoCamera = Builtin::Hall.camera(9, 5);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut renderer = renderer;
    assert_eq!(
        renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap().statistics.shadow_buffer,
        Default::default()
    );
}

/// The lists of the hybrid rule hold primitives that touch a texel. The lists of the other rules hold primitives that
/// cover the texel's centre. The hits at texel centres are the same.
#[test]
fn rules_show_the_same_primitives() {
    let renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    let [hybrid, depth] = [ShadowRule::HYBRID, ShadowRule::DEPTH].map(|rule| {
        let tables = tables_of(&renderer, &uploaded, 100, rule);
        let layers = 0..tables.layers.len() as u32;
        let shown = |texel: Vec<u32>| {
            let slot = texel[texel.len() - 1];
            if slot < UNFILLED { slot & (u32::MAX >> 1) } else { slot }
        };
        let texels = layers.flat_map(|layer| pollster::block_on(tables.read(&renderer.gpu, layer)));
        texels.map(shown).collect::<Vec<_>>()
    });
    assert!(hybrid.iter().filter(|slot| **slot != crate::MISS).count() > 10_000);
    assert_eq!(hybrid.iter().zip(&depth).filter(|(a, b)| a != b).count(), 0);
}
