//! Tests the arithmetic and the counts of the benchmark of Adelson and Hodges 1993, which has no test harness of its
//! own.
#![allow(dead_code, reason = "it is tested by parts")]

#[path = "../benches/adelson-hodges/closed.rs"]
mod closed;
#[path = "../benches/adelson-hodges/counts.rs"]
mod counts;
#[path = "../benches/adelson-hodges/panes.rs"]
mod panes;
#[path = "../benches/adelson-hodges/quanta.rs"]
mod quanta;

use stereotrace::{Gpu, Method, PixelSource, Renderer, blocking::Wait};

use crate::{
    closed::{Levels, Surfaces},
    counts::{LEVELS, options, rays_as_in_the_paper},
    quanta::quanta,
};

#[test]
fn closed_forms_are_the_rays_counted_level_by_level() {
    for surfaces in Surfaces::ALL {
        for (hit, most) in (1..=7).flat_map(|most| (1..=most).map(move |hit| (hit, most))) {
            for lights in 0..6 {
                let levels = Levels { hit, most };
                let (counted, closed) = (surfaces.saved(levels, lights), surfaces.saved_in_closed_form(levels, lights));
                assert!((counted - closed).abs() < 1e-12, "{surfaces:?} {levels:?} {lights}: {counted} {closed}");
            }
        }
        // The paper states one number for each kind of surface, with five levels.
        let saved = 100.0 * surfaces.saved_in_closed_form(Levels { hit: LEVELS, most: LEVELS }, 3);
        let paper: f64 = surfaces.paper().parse().unwrap();
        assert!((saved - paper).abs() < 5e-4, "{surfaces:?}: {saved}");
    }
}

#[test]
fn totals_are_those_that_the_paper_writes_out_but_for_its_power_where_a_product_is_meant() {
    // The paper's totals are N((1 + S) v + 1 if v < L), and N((2^v - 1)(1 + S) + 2^v if v < L).
    let rays = |surfaces: Surfaces, hit, most| surfaces.rays(Levels { hit, most }, 3);
    assert_eq!([rays(Surfaces::DiffuseAndOne, 5, 5), rays(Surfaces::DiffuseAndOne, 2, 5)], [4 * 5, 4 * 2 + 1]);
    assert_eq!([rays(Surfaces::DiffuseAndTwo, 5, 5), rays(Surfaces::DiffuseAndTwo, 2, 5)], [31 * 4, 3 * 4 + 4]);
    assert_eq!([rays(Surfaces::One, 5, 5), rays(Surfaces::Two, 2, 5)], [5, 7]);
    // With the printed power, the left side of the paper's equation is not (1 - M) / L.
    let power = 4.0_f64.powi(5);
    assert!(((power - (power - 4.0)) / power - 0.2).abs() > 0.19);
}

#[test]
fn quanta_are_where_both_projections_of_a_point_round_to_so_many_pixels() {
    for e_px in [12.8, 22.5] {
        // The shift follows equations 3 and 5, in pixels of a picture whose screen is d = 512 away.
        let d = 512.0;
        let shift = |z: f64| {
            let x = 77.0;
            let [left, right] = [-0.5 * e_px, 0.5 * e_px].map(|eye| (x * d + eye * z) / (d + z));
            right - left
        };
        let quanta = quanta(e_px);
        assert_eq!(quanta.first().map(|first| first.from), Some(-0.5));
        assert_eq!(quanta.last().map(|last| last.to), Some(f64::INFINITY));
        assert!(quanta.windows(2).all(|pair| pair[0].to == pair[1].from && pair[0].pixels + 1 == pair[1].pixels));
        for quantum in &quanta {
            let last = if quantum.to.is_finite() { quantum.to } else { 1e12 };
            for share in [1e-6, 0.5, 1.0 - 1e-6] {
                let z = d * (quantum.from + share * (last - quantum.from));
                assert_eq!((shift(z) + 0.5).floor() as i32, quantum.pixels, "{e_px} {quantum:?} {share}");
            }
        }
    }
    let pixels = |e_px: f64| quanta(e_px).iter().map(|quantum| quantum.pixels).collect::<Vec<_>>();
    assert_eq!(pixels(12.8), (-13..=13).collect::<Vec<_>>());
    assert_eq!(pixels(22.5), (-22..=22).collect::<Vec<_>>());
}

#[test]
fn panes_send_as_many_rays_as_the_closed_forms_say_and_the_sweep_saves_that_share() {
    const SIDE: u32 = 32;
    let pixels = u64::from(SIDE * SIDE);
    let adapter = std::env::var("STEREOTRACE_ADAPTER").unwrap_or_else(|_| "software".into());
    let mut renderer = Renderer::new(Gpu::open(adapter).wait().unwrap());
    for surfaces in Surfaces::ALL {
        let (scene, camera) = (panes::scene(surfaces, 2), panes::camera(SIDE, 10.0));
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let naive = renderer.pair(&uploaded, &camera).options(&options(Method::Naive)).read().wait().unwrap();
        let full = naive.statistics.right.rays.total();
        let levels = Levels { hit: LEVELS, most: LEVELS };
        assert_eq!(full, pixels * surfaces.rays(levels, 2), "{surfaces:?}");

        let pair = renderer.pair(&uploaded, &camera).options(&options(Method::ADELSON_HODGES)).read().wait().unwrap();
        let missed = pair.source.iter().filter(|source| **source == PixelSource::Missed).count() as u64;
        // The sky's left edge is e pixels wide. For panes at twice the screen's distance it is half of that.
        let edge = if surfaces == Surfaces::Misses { 10 } else { 5 };
        assert_eq!(missed, u64::from(SIDE) * edge, "{surfaces:?}");
        let rays = rays_as_in_the_paper(&mut renderer, &scene, &camera, &pair).unwrap();
        // A reused pixel saves its own ray and the shadow rays of its first hit.
        let first = if surfaces.is_diffuse() { 3 } else { 1 };
        assert_eq!(rays, full - (pixels - missed) * first, "{surfaces:?}");
    }
}
