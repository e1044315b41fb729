//! x
use stereotrace::*;
use stereotrace::glam::Vec3;
#[test]
fn smoke() {
    let mut scene = Scene::new();
    let red = scene.add_material("red", Vec3::new(0.8, 0.1, 0.1));
    scene.add_sphere(Sphere { center: Vec3::ZERO, radius: 1.0, material: red }).unwrap();
    scene.add_mesh(&Mesh { positions: vec![Vec3::new(-9.,-1.,-9.), Vec3::new(9.,-1.,-9.), Vec3::new(9.,-1.,9.), Vec3::new(-9.,-1.,9.)], triangles: vec![[0,1,2],[0,2,3]], materials: vec![MaterialId(0)], ..Mesh::default()}).unwrap();
    let camera = StereoCamera::look_at(Vec3::new(0.,1.,5.), Vec3::ZERO).size(200,150).interaxial_pixels(10.0);
    scene.place_lights(3, &camera).unwrap();
    let mut r = Renderer::new(Gpu::new().unwrap());
    println!("{}", r.gpu().adapter_name());
    let up = r.upload(&scene).unwrap();
    let naive = r.render(&up, &camera, &Options::new(Method::Naive).counting()).unwrap();
    for (name, m) in Method::ALL {
        let t = std::time::Instant::now();
        let pair = r.render(&up, &camera, &Options::new(m).counting()).unwrap();
        println!("{name} {:?} {:?}", t.elapsed(), pair.statistics);
        println!("{:?}", metrics::compare(&pair.right, &naive.right, &pair.pose).unwrap());
        pair.left.picture().save_png(format!("/tmp/{name}_left.png")).unwrap();
        pair.right.picture().save_png(format!("/tmp/{name}_right.png")).unwrap();
        pair.retrace_picture().save_png(format!("/tmp/{name}_map.png")).unwrap();
        pair.anaglyph(output::Anaglyph::Dubois).save_png(format!("/tmp/{name}_ana.png")).unwrap();
    }
}
