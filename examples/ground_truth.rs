//! Renders a pair of a built-in scene. Writes pictures and ground truth in the formats of stereo stills and stereo
//! vision (docs/FORMATS.md).
//!
//! ```sh
//! cargo run --release --features exr --example ground_truth -- hall 640x480 out
//! ```
//!
//! The cameras are parallel, so disparities are positive, as KITTI requires. With `off-axis` after the folder, the
//! scene's own screen is kept. Disparities are then negative behind the screen, and KITTI's files are left out.

use std::{error::Error, path::Path};

use stereotrace::{
    Builtin, Gpu, Method, Options, Renderer,
    blocking::Wait,
    output::{Batch, ExrColor, Packing},
};

const QUALITY: u8 = 95;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let builtin: Builtin = arguments.next().unwrap_or("hall".into()).parse()?;
    let size = arguments.next().unwrap_or("640x480".into());
    let (width, height) = size.split_once('x').ok_or(format!("'{size}' is no size; use WIDTHxHEIGHT"))?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let folder = arguments.next().unwrap_or("out".into());
    let is_off_axis = match arguments.next().as_deref() {
        None => false,
        Some("off-axis") => true,
        Some(other) => return Err(format!("'{other}' is no kind of camera; use off-axis, or nothing").into()),
    };
    std::fs::create_dir_all(&folder)?;
    let file = |name: &str| Path::new(&folder).join(name);

    let scene = builtin.scene();
    let mut camera = builtin.camera(width, height);
    if !is_off_axis {
        camera = camera.interaxial(camera.pose()?.interaxial).screen_distance(f32::INFINITY);
    }
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let uploaded = renderer.upload(&scene).wait()?;
    let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Auto).linear(true)).read().wait()?;
    let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait()?;

    let mut files = Batch::new();
    for (n, view, eye) in [(0, &pair.left, &truth.left), (1, &pair.right, &truth.right)] {
        files.add_png(file(&format!("im{n}.png")), &view.picture())?;
        files.add_jpeg(file(&format!("im{n}.jpg")), &view.picture(), QUALITY)?;
        files.add_pfm(file(&format!("disp{n}.pfm")), width, height, &eye.disparity)?;
        files.add_nocc_mask(file(&format!("mask{n}nocc.png")), eye)?;
        files.add_occlusion(file(&format!("occlusion{n}.png")), eye)?;
        files.add_sky_mask(file(&format!("sky{n}.png")), eye)?;
        files.add_pfm(file(&format!("depth{n}.pfm")), width, height, &eye.depth)?;
        files.add_pfm(file(&format!("distance{n}.pfm")), width, height, &eye.distance)?;
        files.add_pfm_color(file(&format!("normals{n}.pfm")), width, height, &eye.shading_normal)?;
        files.add_pfm_color(file(&format!("geometric_normals{n}.pfm")), width, height, &eye.geometric_normal)?;
        let in_camera = truth.pose.in_camera(&eye.shading_normal);
        files.add_pfm_color(file(&format!("camera_normals{n}.pfm")), width, height, &in_camera)?;
        files.add_ids_png(file(&format!("objects{n}.png")), width, height, &eye.object)?;
        files.add_ids_png(file(&format!("materials{n}.png")), width, height, &eye.material)?;
        files.add_primitive_ids(file(&format!("primitives{n}.pfm")), view)?; // ids may exceed 65,534
        if !is_off_axis {
            let (all, of_both) = (eye.surfaces(), eye.surfaces_of_both());
            files.add_kitti_disparity(file(&format!("disp_occ_{n}.png")), width, height, &eye.disparity, &all)?;
            files.add_kitti_disparity(file(&format!("disp_noc_{n}.png")), width, height, &eye.disparity, &of_both)?;
        }
    }
    files.add_calib(file("calib.txt"), &truth)?;
    files.add_camera_json(file("camera.json"), &truth.pose)?;
    files.add_exr(file("pair.exr"), &pair, Some(&truth), ExrColor::Float)?;
    files.add_exr(file("pair_half.exr"), &pair, None, ExrColor::Half)?;
    files.add_jps(file("pair.jps"), &pair, QUALITY)?;
    files.add_mpo(file("pair.mpo"), &pair, QUALITY)?;
    for &packing in Packing::ALL {
        files.add_png(file(&format!("{packing}.png")), &pair.packed(packing))?;
    }
    println!("{} files of {builtin} in {folder}, by {}", files.commit()?.len(), renderer.gpu().adapter_name());
    Ok(())
}
