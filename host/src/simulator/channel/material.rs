//! Building materials by Recommendation ITU-R P.2040-3: permittivity at the carrier, and what a half space or a slab reflects.
//!
//! Clause 3 (Table 3): eta' = a f^b and sigma = c f^d with f in GHz, eta = eta' - j 17.98 sigma / f (eq. (9b) of the recommendation).
//! Clause 2.2.2: a slab of thickness d reflects R = R' (1 - exp(-j 2 q)) / (1 - R'^2 exp(-j 2 q)) with q = 2 pi d / lambda
//! sqrt(eta - sin^2 theta) and R' the half space's coefficient.

use super::{Complex64, phasor, wavelength};
use crate::scenario::{Material, Surface};
use std::f64::consts::PI;

/// a, b, c, d of Table 3. They hold for 1 to 100 GHz, those of brick and plywood to 40 GHz, those of marble to 60 GHz.
fn table(material: Material) -> [f64; 4] {
    match material {
        Material::Concrete => [5.24, 0.0, 0.0462, 0.7822],
        Material::Brick => [3.91, 0.0, 0.0238, 0.16],
        Material::Plasterboard => [2.73, 0.0, 0.0085, 0.9395],
        Material::Wood => [1.99, 0.0, 0.0047, 1.0718],
        Material::Glass => [6.31, 0.0, 0.0036, 1.3394],
        Material::CeilingBoard => [1.48, 0.0, 0.0011, 1.0750],
        Material::Chipboard => [2.58, 0.0, 0.0217, 0.7800],
        Material::Plywood => [2.71, 0.0, 0.33, 0.0],
        Material::Marble => [7.074, 0.0, 0.0055, 0.9262],
        Material::Metal => [1.0, 0.0, 1e7, 0.0],
    }
}

/// Complex relative permittivity at a carrier; losses are the negative imaginary part.
pub fn permittivity(material: Material, carrier_hz: f64) -> Complex64 {
    let [a, b, c, d] = table(material);
    let f = carrier_hz * 1e-9;
    let conductivity = c * libm::pow(f, d);
    Complex64::new(a * libm::pow(f, b), -17.98 * conductivity / f)
}

/// Square root with a non-negative real part, by IEEE operations alone.
fn root(z: Complex64) -> Complex64 {
    let length = z.norm_sqr().sqrt();
    let re = (0.5 * (length + z.re)).max(0.0).sqrt();
    let im = (0.5 * (length - z.re)).max(0.0).sqrt();
    Complex64::new(re, if z.im < 0.0 { -im } else { im })
}

/// Fresnel's coefficient of a half space at the cosine of the angle of incidence: electric field parallel to the plane of incidence
/// (TM, eq. (31b)) or perpendicular to it (TE, eq. (31a)).
pub fn half_space(permittivity: Complex64, cosine: f64, parallel: bool) -> Complex64 {
    let root = root(permittivity - (1.0 - cosine * cosine));
    let c = Complex64::new(cosine, 0.0);
    if parallel { (permittivity * c - root) / (permittivity * c + root) } else { (c - root) / (c + root) }
}

/// A slab in air at a carrier: a surface of a room.
#[derive(Debug, Clone, Copy)]
pub struct Slab {
    permittivity: Complex64,
    /// 2 pi d / lambda.
    thickness: f64,
}

impl Slab {
    /// Of a surface's material and thickness.
    pub fn new(surface: &Surface, carrier_hz: f64) -> Self {
        Slab {
            permittivity: permittivity(surface.material, carrier_hz),
            thickness: 2.0 * PI * surface.thickness_m / wavelength(carrier_hz),
        }
    }

    /// What it reflects at the cosine of the angle of incidence.
    pub fn reflected(&self, cosine: f64, parallel: bool) -> Complex64 {
        let single = half_space(self.permittivity, cosine, parallel);
        let q = root(self.permittivity - (1.0 - cosine * cosine)) * self.thickness;
        // exp(-j 2 q): the way through the slab and back
        let round_trip = phasor(-2.0 * q.re) * libm::exp(2.0 * q.im);
        let one = Complex64::new(1.0, 0.0);
        single * (one - round_trip) / (one - single * single * round_trip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permittivities_are_those_of_the_recommendation() {
        // computed by hand from Table 3: concrete at 3.5 and 60 GHz, glass at 24 GHz
        for (material, ghz, real, conductivity) in [
            (Material::Concrete, 3.5, 5.24, 0.0462 * 2.664_2),
            (Material::Concrete, 60.0, 5.24, 0.0462 * 24.595),
            (Material::Glass, 24.0, 6.31, 0.0036 * 70.58),
            (Material::Plasterboard, 60.0, 2.73, 0.0085 * 46.83),
        ] {
            let eta = permittivity(material, ghz * 1e9);
            assert!((eta.re - real).abs() < 1e-9, "{material:?}: {eta}");
            assert!((-eta.im * ghz / 17.98 / conductivity - 1.0).abs() < 2e-3, "{material:?}: {eta}");
        }
    }

    #[test]
    fn half_spaces_know_normal_grazing_and_brewster() {
        let real = Complex64::new(4.0, 0.0);
        assert!((half_space(real, 1.0, false).re + 1.0 / 3.0).abs() < 1e-12);
        assert!((half_space(real, 1.0, true).re - 1.0 / 3.0).abs() < 1e-12);
        assert!((half_space(real, 1e-9, false).re + 1.0).abs() < 1e-6);
        // Brewster's angle: tan = sqrt(4)
        assert!(half_space(real, 1.0 / 5.0_f64.sqrt(), true).norm_sqr() < 1e-24);
        let metal = permittivity(Material::Metal, 3.5e9);
        assert!((half_space(metal, 0.7, false).norm_sqr() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn slabs_resonate_lose_and_conserve_energy() {
        let glass = |thickness_m| Surface { material: Material::Glass, thickness_m };
        let carrier = 3.5e9;
        let eta = permittivity(Material::Glass, carrier);
        // half a wavelength of glass at normal incidence reflects almost nothing, a quarter the most
        let inside = wavelength(carrier) / eta.re.sqrt();
        let half = Slab::new(&glass(inside / 2.0), carrier).reflected(1.0, false).norm_sqr();
        let quarter = Slab::new(&glass(inside / 4.0), carrier).reflected(1.0, false).norm_sqr();
        let expected = (eta.re - 1.0) / (eta.re + 1.0);
        assert!(half < 1e-3, "{half}");
        assert!((quarter / (expected * expected) - 1.0).abs() < 0.02, "{quarter}");
        // a thick lossy wall is a half space
        let wall = Surface { material: Material::Concrete, thickness_m: 2.0 };
        for (cosine, parallel) in [(1.0, false), (0.5, false), (0.5, true)] {
            let exact = half_space(permittivity(Material::Concrete, 60e9), cosine, parallel);
            let db = 10.0
                * libm::log10(
                    Slab::new(&wall, 60e9).reflected(cosine, parallel).norm_sqr() / exact.norm_sqr(),
                );
            assert!(db.abs() < 0.1, "{db} dB");
            assert!(exact.norm_sqr() < 1.0);
        }
    }
}
