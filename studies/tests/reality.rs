//! Tests the arithmetic of the benchmark of Raghuvanshi and Dhande, which has no test harness of its own.
#![allow(dead_code, reason = "it is tested by parts")]

#[path = "../benches/reality/fits.rs"]
mod fits;
use stereotrace::testing::random;

use crate::{
    fits::{Line, Parabola, Point},
    random::Random,
};

fn near(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() <= 1e-9 * wanted.abs().max(1.0)
}

#[test]
fn lines_are_those_of_least_squares() {
    let exact = Line::through(&[(10.0, 32.0), (500.0, 1502.0), (6000.0, 18002.0)]).unwrap();
    assert!(near(exact.slope, 3.0) && near(exact.intercept, 2.0) && near(exact.r_squared, 1.0), "{exact:?}");
    // By hand: means are 1 and 2/3, products 1, squares 2; residuals are -1/6, 1/3, -1/6 of a sum of squares of 2/3.
    let line = Line::through(&[(0.0, 0.0), (1.0, 1.0), (2.0, 1.0)]).unwrap();
    assert!(near(line.slope, 0.5) && near(line.intercept, 1.0 / 6.0) && near(line.r_squared, 0.75), "{line:?}");
    assert!(near(line.at(4.0), 2.0 + 1.0 / 6.0));
}

#[test]
fn parabolas_are_those_of_least_squares() {
    let of = |x: f64| 40.0 - 0.02 * x + 3e-5 * x * x;
    let points: Vec<Point> = (1..=10).map(|k| 200.0 * f64::from(k)).map(|x| (x, of(x))).collect();
    let exact = Parabola::through(&points).unwrap();
    assert!((exact.constant - 40.0).abs() < 1e-8 && (exact.linear + 0.02).abs() < 1e-11, "{exact:?}");
    assert!((exact.square - 3e-5).abs() < 1e-14 && near(exact.r_squared, 1.0), "{exact:?}");
    assert!(near(exact.at(3000.0), of(3000.0)));
    // By hand, in the polynomials 1, x and (x² - 5) / 4, which are orthogonal at these places: the fit is 1 + 0.3 x +
    // (x² - 5) / 4. The residuals are 0.1, 0.3, 0.3, 0.1 of a sum of squares of 6.
    let found = Parabola::through(&[(-3.0, 1.0), (-1.0, 0.0), (1.0, 0.0), (3.0, 3.0)]).unwrap();
    assert!(near(found.constant, -0.25) && near(found.linear, 0.3) && near(found.square, 0.25), "{found:?}");
    assert!(near(found.r_squared, 1.0 - 0.2 / 6.0), "{found:?}");
    // If a line is the best parabola, both fits agree.
    let points = [(-3.0, 0.0), (-1.0, 1.0), (1.0, 1.0), (3.0, 2.0)];
    let (parabola, line) = (Parabola::through(&points).unwrap(), Line::through(&points).unwrap());
    assert!(parabola.square.abs() < 1e-12 && near(parabola.linear, line.slope) && near(line.slope, 0.3));
    assert!(near(parabola.r_squared, 0.9) && near(line.r_squared, 0.9));
}

#[test]
fn no_other_coefficients_leave_less() {
    let mut random = Random(7);
    for count in [4, 11, 40] {
        let points: Vec<Point> = (0..count)
            .map(|k| (200.0 * f64::from(k), f64::from(random.between(0.0, 9.0)) + 1e-5 * f64::from(k * k)))
            .collect();
        let left = |of: &dyn Fn(f64) -> f64| points.iter().map(|&(x, y)| (y - of(x)).powi(2)).sum::<f64>();
        let (line, parabola) = (Line::through(&points).unwrap(), Parabola::through(&points).unwrap());
        let (by_line, by_parabola) = (left(&|x| line.at(x)), left(&|x| parabola.at(x)));
        assert!(by_parabola <= by_line * (1.0 + 1e-12) && parabola.r_squared >= line.r_squared - 1e-12);
        let reach = 200.0 * f64::from(count);
        for step in [-1e-3, 1e-3] {
            for power in 0..3 {
                let more = |x: f64| step * (x / reach).powi(power);
                assert!(power == 2 || left(&|x| line.at(x) + more(x)) > by_line, "{count}: {power}");
                assert!(left(&|x| parabola.at(x) + more(x)) > by_parabola, "{count}: {power}");
            }
        }
    }
}

#[test]
fn too_few_places_have_no_curve_and_level_ones_explain_nothing() {
    assert_eq!(Line::through(&[]), None);
    assert_eq!(Line::through(&[(2.0, 1.0), (2.0, 3.0)]), None);
    assert_eq!(Parabola::through(&[]), None);
    assert_eq!(Parabola::through(&[(1.0, 1.0), (2.0, 3.0)]), None);
    assert_eq!(Parabola::through(&[(1.0, 1.0), (2.0, 3.0), (1.0, 2.0), (2.0, 2.0)]), None);
    let level = Line::through(&[(0.0, 5.0), (1.0, 5.0)]).unwrap();
    assert!(level.slope == 0.0 && level.intercept == 5.0 && level.r_squared.is_nan());
}
