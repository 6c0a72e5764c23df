//! Where there is no loop by hand for the processor's architecture.

use core::marker::PhantomData;

/// Bodies as columns of their own.
#[derive(Clone, Debug)]
pub struct Attracting<P> {
    /// Accelerations of the last call.
    pub acceleration: [Vec<f64>; 3],
    precision: PhantomData<P>,
}

impl<P> Attracting<P> {
    /// The bodies of these places and one mass.
    pub fn new(position: &[[f64; 3]], _mass: f64) -> Self {
        Attracting { acceleration: [0, 1, 2].map(|_| vec![0.0; position.len()]), precision: PhantomData }
    }
}

/// A loop with its name.
pub type Loop<P> = (&'static str, unsafe fn(&mut Attracting<P>, P));

/// None.
pub fn f32_loops() -> Vec<Loop<f32>> {
    Vec::new()
}

/// None.
pub fn f64_loops() -> Vec<Loop<f64>> {
    Vec::new()
}
