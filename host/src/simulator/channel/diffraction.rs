//! Diffraction around screens by Kirchhoff's integral.
//!
//! The wave behind a rectangular screen is the free wave less what passes where the screen stands (Babinet):
//! 1 - (j / 2) F_w F_h with F = integral of exp(-j pi t^2 / 2) between two edges, at v = +-2 sqrt(D / lambda) where the path around an edge
//! is D longer, the parameter of Recommendation ITU-R P.526-15. Its clause 4.1 is the case of a half plane: J(0) = 6 dB. What an
//! edge adds is weighted by the cosines of the angles at which it is seen from both ends (Rayleigh and Sommerfeld's obliquity factors): it
//! vanishes as the screen comes to stand beside an end. The delay stays that of the
//! straight path, which at bandwidths below some GHz cannot be distinguished from the path around an edge.

use super::Complex64;
use super::shadowing::{Leg, Screen};
use crate::numerics::fresnel::fresnel;

/// The integral up to an edge `h` aside of the path, `d1` and `d2` from its ends, in m.
fn edge(h: f64, [d1, d2]: [f64; 2], lambda: f64) -> Complex64 {
    let [a, b] = [d1, d2].map(|d| (d * d + h * h).sqrt());
    let v = 2.0 * ((a + b - d1 - d2).max(0.0) / lambda).sqrt();
    let (c, s) = fresnel(v);
    let limit = Complex64::new(0.5, -0.5);
    let value = limit - (limit - Complex64::new(c, -s)) * (d1 / a * (d2 / b));
    if h < 0.0 { -value } else { value }
}

/// What a leg keeps of its wave behind a screen: by Kirchhoff's integral, or nothing in its shadow.
fn passed(screen: &Screen, leg: Leg, lambda: f64, diffraction: bool) -> Complex64 {
    let one = Complex64::new(1.0, 0.0);
    let Some(c) = screen.crossing(leg) else { return one };
    if !diffraction {
        let hidden = [c.across, c.heights].iter().all(|[low, high]| *low <= 0.0 && *high >= 0.0);
        return if hidden { Complex64::default() } else { one };
    }
    let ends = [c.at / c.tilt, (c.leg_m - c.at) / c.tilt];
    let between = |[low, high]: [f64; 2]| edge(high, ends, lambda) - edge(low, ends, lambda);
    one - between(c.across) * between(c.heights) * Complex64::new(0.0, 0.5)
}

/// What a path of several legs keeps behind all screens. One that comes back the way it went out loses the same twice.
pub fn kept(screens: &[Screen], legs: &[Leg], lambda: f64, diffraction: bool) -> Complex64 {
    let of = |leg: &Leg| screens.iter().map(|s| passed(s, *leg, lambda, diffraction)).product::<Complex64>();
    match legs {
        [out, back] if *back == (out.1, out.0) => {
            let once = of(out);
            once * once
        }
        _ => legs.iter().map(of).product(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEG: Leg = ([0.0, 0.0, 1.0], [6.0, 0.0, 1.0]);
    const LAMBDA: f64 = 5e-3;

    /// A screen much wider than the Fresnel zone with its upper edge at `z`.
    fn half_plane(z: f64) -> Screen {
        Screen { place: [3.0, 0.0], heights: [-200.0, z], width: 400.0 }
    }

    fn db(screen: &Screen, diffraction: bool) -> f64 {
        10.0 * libm::log10(kept(&[*screen], &[LEG], LAMBDA, diffraction).norm_sqr())
    }

    #[test]
    fn a_knife_edge_costs_what_the_recommendation_says() {
        let grazing = db(&half_plane(1.0), true);
        println!("number: knife edge at grazing incidence {grazing:.2} dB, ITU-R P.526: -6.02 dB");
        assert!((grazing + 6.02).abs() < 0.05, "{grazing}");
        // at v: eq. (31) of the recommendation, J = 6.9 + 20 log(sqrt((v - 0.1)^2 + 1) + v - 0.1), within its 0.3 dB
        let metre = (2.0_f64 * (2.0 / 3.0) / LAMBDA).sqrt();
        for v in [-0.7, 0.5, 1.0, 2.0, 4.0] {
            let x: f64 = v - 0.1;
            let exact = -6.9 - 20.0 * libm::log10((x * x + 1.0).sqrt() + x);
            let found = db(&half_plane(1.0 + v / metre), true);
            assert!((found - exact).abs() < 0.3, "v = {v}: {found} {exact}");
        }
    }

    #[test]
    fn a_screen_and_its_opening_are_the_free_wave() {
        // Babinet: below, above and beside one another, four quarter planes make a whole plane, which keeps nothing
        let quarter = |y: f64, z: [f64; 2]| {
            let screen = Screen { place: [3.0, y], heights: z, width: 200.0 };
            Complex64::new(1.0, 0.0) - kept(&[screen], &[LEG], LAMBDA, true)
        };
        let sum: Complex64 =
            [-100.1, 99.9].iter().flat_map(|&y| [[-200.0, 1.1], [1.1, 200.0]].map(|z| quarter(y, z))).sum();
        assert!((sum - 1.0).norm_sqr() < 1e-5, "{sum}");
    }

    #[test]
    fn a_passing_screen_changes_little_from_millimetre_to_millimetre() {
        let mut last = None;
        for k in -1000..1000 {
            // past the end of a leg, half a metre aside
            let screen = Screen { place: [6.0 + 1e-3 * f64::from(k), 0.5], heights: [0.0, 1.7], width: 0.3 };
            let now = kept(&[screen], &[LEG], LAMBDA, true);
            let step = now - last.replace(now).unwrap_or(now);
            assert!(step.norm_sqr() < 0.02 * 0.02, "{k} mm: {step}");
        }
    }

    #[test]
    fn the_way_back_loses_what_the_way_out_does() {
        let screens = [half_plane(0.9), Screen { place: [2.0, 0.3], heights: [0.0, 1.7], width: 0.3 }];
        let (a, b) = ([0.3, -0.2, 0.5], [5.0, 0.4, 1.9]);
        let both = kept(&screens, &[(a, b), (b, a)], LAMBDA, true);
        let each = kept(&screens, &[(a, b)], LAMBDA, true) * kept(&screens, &[(b, a)], LAMBDA, true);
        assert!((both - each).norm_sqr() < 1e-24 && both.norm_sqr() > 0.0, "{both} {each}");
    }

    #[test]
    fn without_diffraction_a_shadow_is_sharp() {
        let one = |y: f64| {
            let screen = Screen { place: [3.0, y], heights: [0.0, 1.7], width: 0.3 };
            kept(&[screen], &[LEG], LAMBDA, false)
        };
        assert_eq!((one(0.149).re, one(0.151).re), (0.0, 1.0));
    }
}
