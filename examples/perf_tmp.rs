//! tmp
use stereotrace::{scene::builtin::Builtin, *};
fn main() {
    let mut r = Renderer::new(Gpu::new().unwrap());
    let dir = std::env::var("STEREOTRACE_SCENES").unwrap_or("target/scenes".into());
    let mut list: Vec<(String, Scene, StereoCamera)> = vec![];
    for b in [Builtin::Spheres, Builtin::Hall] {
        list.push((b.name().into(), b.scene(), b.camera(600, 600)));
    }
    for n in ["sponza_4x", "dragon"] {
        let c = StereoCamera::from_json(format!("{dir}/cameras.json"), n, 600, 600).unwrap().interaxial_pixels(15.0);
        let mut s = Scene::from_obj(format!("{dir}/{n}/{n}.obj")).unwrap();
        s.place_lights(5, &c).unwrap();
        list.push((n.into(), s, c));
    }
    let want = std::env::args().nth(1);
    for (name, scene, cam) in list {
        if want.as_ref().is_some_and(|w| *w != name) {
            continue;
        }
        let t = std::time::Instant::now();
        let up = r.upload(&scene).unwrap();
        println!("== {name} upload {:?}", t.elapsed());
        let methods = [
            ("naive", Method::Naive),
            ("ideal", Method::Ideal),
            ("atomic", Method::ATOMIC),
            ("buffer", Method::BUFFER),
        ];
        let mut times = vec![vec![]; 4];
        let mut last = vec![None; 4];
        for round in 0..6 {
            for k in 0..4 {
                let (_, m) = methods[(k + round) % 4];
                let s = r.trace(&up, &cam, &Options::new(m)).unwrap();
                if round > 0 {
                    times[(k + round) % 4].push(s.times.as_ref().unwrap().total().as_secs_f64() * 1e3);
                    last[(k + round) % 4] = s.times.clone();
                }
            }
        }
        let med: Vec<f64> = times
            .iter_mut()
            .map(|t| {
                t.sort_by(f64::total_cmp);
                t[t.len() / 2]
            })
            .collect();
        let c = r.trace(&up, &cam, &Options::new(Method::ATOMIC).counting()).unwrap();
        let m = c.second_eye();
        let naive = r.trace(&up, &cam, &Options::new(Method::Naive).counting()).unwrap();
        println!(
            "naive m {:.3}  nodes/ray {:.1} tests/ray {:.1}",
            naive.second_eye(),
            naive.left.nodes as f64 / naive.left.rays.total() as f64,
            naive.left.primitive_tests as f64 / naive.left.rays.total() as f64
        );
        println!(
            "atomic: right rays {:?} m {m:.3} predicted {:.1}%  measured {:.1}%  ratio {:.2}",
            c.right.rays,
            100.0 * (2.0 / (1.0 + m) - 1.0),
            100.0 * (med[0] / med[2] - 1.0),
            (med[0] / med[2] - 1.0) / (2.0 / (1.0 + m) - 1.0)
        );
        for k in 0..4 {
            println!("{:8} {:8.1} ms  {:?}", methods[k].0, med[k], last[k].as_ref().unwrap().0);
        }
        println!("Mrays/s left {:.2}", naive.left.rays.total() as f64 / (med[1]) / 1e3);
    }
}
