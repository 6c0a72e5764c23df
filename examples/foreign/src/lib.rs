//! Newton's law of universal gravitation, as a law crate outside the workspace would have it.
//!
//! F_i = sum over j of G m_i m_j (x_j - x_i) / (r^2 + e^2)^(3/2), e the softening length.
//! Source: Newton, Principia, book III, prop. 7; the softening: Plummer, MNRAS 71 (1911) 460.
//! Wrong at speeds near that of light, and nearer to a body than its own size.

use vesper::prelude::*;

/// Newton's law of universal gravitation between point masses, softened as by Plummer.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), antisymmetric, estimates)]
pub struct Gravity<R = f64> {
    /// Constant of gravitation (CODATA 2022).
    #[law(unit = "m^3 kg^-1 s^-2", default = 6.674_30e-11)]
    pub g: R,
    /// Softening length.
    #[law(unit = "m", default = 0.0)]
    pub softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Gravity<R> {
    fn pair(&self, i: GravityRow<R>, j: GravityRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared() + self.softening * self.softening;
        d * (self.g * i.mass * j.mass).over_root_cubed(r2)
    }

    fn inverse_square(&self, row: GravityRow<R>) -> InverseSquare<R> {
        InverseSquare { source: row.mass, response: self.g * row.mass, softening: self.softening }
    }
}
