//! Tests materials by the rules of docs/FORMATS.md.

use serde_json::{Value, json};
use stereotrace::{Finish, Material, Principled, glam::Vec3};

use super::{assert_near, gltf::Builder, material, scene};

fn read(description: Value) -> Material {
    material(&scene(Builder::triangle(description).text())).clone()
}

fn metallic(color: [f32; 4], metal: f32, roughness: f32) -> Value {
    let shine = json!({ "baseColorFactor": color, "metallicFactor": metal, "roughnessFactor": roughness });
    json!({ "name": "one", "pbrMetallicRoughness": shine })
}

#[test]
fn rough_dielectrics_are_diffuse_by_their_linear_colour() {
    let mut found = read(metallic([0.2, 0.5, 1.0, 1.0], 0.0, 1.0));
    assert_eq!(found.principled.take(), Some(Principled::new(Vec3::new(0.2, 0.5, 1.0), 0.0, 1.0)));
    assert_eq!(found, Material::new(Vec3::new(0.2, 0.5, 1.0)).name("one").exponent(0.0).normalised(true));
}

#[test]
fn metal_and_roughness_share_the_light_out() {
    let base = Vec3::new(0.9, 0.6, 0.3);
    let of = |metal, roughness| read(metallic([0.9, 0.6, 0.3, 1.0], metal, roughness));
    let plastic = of(0.0, 0.5);
    assert_near(plastic.albedo, base * 0.98);
    assert_near(plastic.specular, Vec3::splat(0.02));
    assert_eq!((plastic.exponent, plastic.finish, plastic.normalised), (7.5, Finish::Matte, true));
    let brushed = of(1.0, 0.5);
    assert_near(brushed.albedo, 0.5 * base);
    assert_near(brushed.specular, 0.5 * base);
    let silver = of(1.0, 0.1);
    assert_eq!((silver.albedo, silver.specular, silver.finish), (Vec3::ZERO, base, Finish::Mirror { fresnel: true }));
    let polished = of(0.0, 0.0);
    assert_near(polished.albedo, 0.96 * base);
    assert_near(polished.specular, Vec3::splat(0.04));
    assert_eq!((polished.exponent, polished.finish), (10_000.0, Finish::Mirror { fresnel: true }));
    // Without any field, the specification's defaults apply.
    let plain = read(json!({}));
    assert_eq!((plain.albedo, plain.specular), (Vec3::ONE, Vec3::ZERO));
    // A material returns at most the light that it receives, for any metal and roughness.
    for step in 0..=100 {
        let (metal, roughness) = ((step % 11) as f32 / 10.0, (step / 11) as f32 / 9.0);
        let one = read(metallic([1.0; 4], metal, roughness.min(1.0)));
        assert!((one.albedo + one.specular).max_element() <= 1.00001, "{one:?}");
    }
}

#[test]
fn emission_unlit_and_glass_are_read() {
    let lamp = read(json!({ "emissiveFactor": [1, 0.5, 0.25],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } } }));
    assert_eq!(lamp.emission, Vec3::new(8.0, 4.0, 2.0));
    let mut unlit = metallic([0.2, 0.4, 0.6, 1.0], 0.0, 0.2);
    unlit["extensions"] = json!({ "KHR_materials_unlit": {} });
    let unlit = read(unlit);
    assert_eq!((unlit.albedo, unlit.specular, unlit.emission), (Vec3::ZERO, Vec3::ZERO, Vec3::new(0.2, 0.4, 0.6)));
    let mut glass = metallic([0.9, 0.8, 0.7, 1.0], 0.0, 0.0);
    glass["extensions"] =
        json!({ "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.33 } });
    let glass = read(glass);
    let Finish::Glass { index, transmission, fresnel: true } = glass.finish else { panic!("{glass:?}") };
    assert_eq!((index, glass.albedo), (1.33, Vec3::ZERO));
    assert_near(transmission, Vec3::new(0.9, 0.8, 0.7));
}

#[test]
fn alpha_without_a_texture_is_a_veil_or_nothing() {
    let opacity = |mode: &str, alpha: f32| {
        let mut description = metallic([1.0, 1.0, 1.0, alpha], 0.0, 1.0);
        description["alphaMode"] = json!(mode);
        read(description).opacity
    };
    let opacities =
        [("OPAQUE", 0.3), ("BLEND", 0.3), ("MASK", 0.3), ("MASK", 0.5)].map(|(mode, alpha)| opacity(mode, alpha));
    assert_eq!(opacities, [1.0, 0.3, 0.0, 1.0]);
}

#[test]
fn values_out_of_range_are_brought_into_it() {
    let found = read(metallic([2.0, -1.0, 0.5, 1.0], -3.0, 7.0));
    assert_near(found.albedo, Vec3::new(1.0, 0.0, 0.5));
}
