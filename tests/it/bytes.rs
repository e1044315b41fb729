//! Hashes all outputs of each method, to check that a change of the code alters no picture. `sh scripts/same_bytes.sh
//! COMMIT` compares the hashes with the hashes of another commit, on the same machine.

use std::{
    fmt::Write,
    fs,
    hash::{DefaultHasher, Hash, Hasher},
};

use stereotrace::{
    Adaptive, AmbientOcclusion, GBuffer, Light, Method, Options, Scene, ShadowBuffer, StereoCamera, StereoPair,
    Visibility, blocking::Wait, scene::builtin::Builtin, testing::suite::Trial,
};

use crate::common::{random_stage, renderer};

/// Name of the environment variable for the file that the hashes are written to.
const FILE: &str = "STEREOTRACE_BYTES";

/// Returns scenes with triangles, with spheres, with both, with mirrors and glass, with textures, with masks, and with
/// all of these.
fn scenes() -> Vec<(&'static str, Scene, StereoCamera)> {
    let builtin =
        |builtin: Builtin, [width, height]: [u32; 2]| (builtin.name(), builtin.scene(), builtin.camera(width, height));
    let foliage = Trial::Foliage;
    vec![
        builtin(Builtin::Hall, [97, 61]),
        builtin(Builtin::Spheres, [83, 57]),
        builtin(Builtin::Near, [71, 67]),
        builtin(Builtin::ThreeSpheresMirrors, [79, 53]),
        builtin(Builtin::HallFinished, [65, 43]),
        (foliage.name(), foliage.scene(), foliage.camera(73, 71)),
        ("random", random_stage(7), Builtin::Random20.camera(59, 47)),
    ]
}

/// Returns sets of options, each with a name and whether all methods are rendered with it.
fn settings() -> Vec<(&'static str, Options, bool)> {
    let plain = || Options::default().linear(true).g_buffer(GBuffer::Ids);
    vec![
        ("plain", plain(), true),
        ("counted", plain().count(true).cost_map(true), false),
        ("samples", plain().samples(4).jitter(true), false),
        ("adaptive", plain().adaptive(Adaptive::new(2, 0.05)), false),
        ("soft", plain().shadow_rays(4).ambient_occlusion(AmbientOcclusion::new(4, 1.0)), false),
        ("sky", plain().sky_rays(4), false),
        ("t-buffer", plain().visibility(Visibility::TBuffer), false),
        ("shadow-buffer", plain().shadow_buffer(ShadowBuffer::new(64)), false),
    ]
}

fn hash_of(what: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    what.hash(&mut hasher);
    hasher.finish()
}

/// Returns a hash of each part of a pair, so that the hashes show which part differs.
fn text(pair: &StereoPair) -> String {
    let views = [&pair.left, &pair.right];
    let statistics = &pair.statistics;
    let parts = [
        ("picture", hash_of(views.map(|view| &view.rgba8))),
        ("linear", hash_of(views.map(|view| bits_of(&view.linear)))),
        ("depth", hash_of(views.map(|view| view.depth.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>()))),
        ("ids", hash_of(views.map(|view| (&view.primitive, &view.object)))),
        ("cost", hash_of(views.map(|view| &view.cost))),
        ("sources", hash_of((format!("{:?}", pair.source), format!("{:?}", pair.shadow_source)))),
        ("counters", hash_of(format!("{:?} {:?} {:?}", statistics.choice, statistics.left, statistics.right))),
        (
            "marks",
            hash_of((
                statistics.reused,
                statistics.bad,
                statistics.missed,
                statistics.lost_candidates,
                statistics.buffer_depth,
            )),
        ),
    ];
    parts.iter().fold(String::new(), |text, (name, hash)| text + &format!(" {name}={hash:016x}"))
}

fn bits_of(colors: &[[f32; 4]]) -> Vec<[u32; 4]> {
    colors.iter().map(|color| color.map(f32::to_bits)).collect()
}

#[test]
#[ignore = "a guard of a few minutes: scripts/same_bytes.sh"]
fn every_method_makes_the_bytes_that_it_made() {
    let some = [Method::Naive, Method::Auto, Method::BRACKET, Method::VERIFIED, Method::BRACKET_RAYS, Method::ATOMIC];
    let mut all = String::new();
    for (name, mut scene, camera) in scenes() {
        let hard = scene.lights.clone();
        for (setting, options, by_all) in settings() {
            scene.lights = hard.clone();
            if setting == "soft" {
                let radius = 0.01 * camera.pose().unwrap().screen_distance;
                for light in &mut scene.lights {
                    *light = Light::sphere(light.position, radius, light.intensity);
                }
            }
            let mut renderer = renderer();
            let uploaded = renderer.upload(&scene).wait().unwrap();
            for &method in if by_all { Method::ALL } else { &some } {
                let made = renderer.pair(&uploaded, &camera).options(&options.clone().method(method)).read().wait();
                let mut made = made.as_ref().map_or_else(|error| format!(" refused: {error}"), text);
                if setting == "shadow-buffer" {
                    // The number of traced rays depends on which points share a lane, and differs from run to run.
                    made.truncate(made.find(" counters").unwrap_or(made.len()));
                }
                writeln!(all, "{name} {setting} {method}{made}").unwrap();
            }
        }
    }
    let file = std::env::var_os(FILE).unwrap_or_else(|| panic!("{FILE} names the file that the hashes go to"));
    fs::write(file, all).unwrap();
}
