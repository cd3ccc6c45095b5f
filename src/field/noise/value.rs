//! Value noise: a number at each corner of the cells, and smoothly from one to the next.

use glam::{DVec3, I64Vec3};

use super::hash::{of_cell, share};
use super::{Noise, fade};

/// Value noise.
#[derive(Clone, Copy, Debug)]
pub struct ValueNoise {
    /// What it starts from.
    pub seed: u64,
}

impl Noise for ValueNoise {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let base = position.floor();
        if !base.is_finite() {
            return (f64::NAN, DVec3::NAN);
        }
        let (cell, within) = (base.as_i64vec3(), position - base);
        let [x, y, z] = within.to_array().map(fade);
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for corner in 0..8 {
            let by = I64Vec3::new(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
            let weight =
                |(share, slope): (f64, f64), far: i64| if far == 1 { (share, slope) } else { (1.0 - share, -slope) };
            let [(wx, sx), (wy, sy), (wz, sz)] = [weight(x, by.x), weight(y, by.y), weight(z, by.z)];
            let number = share(of_cell(cell + by, self.seed));
            value += number * (wx * wy * wz);
            slope += number * DVec3::new(sx * wy * wz, wx * sy * wz, wx * wy * sz);
        }
        (value.clamp(0.0, 1.0), slope)
    }

    /// The slope of the fade, 15/8, along each axis.
    fn steepest(&self) -> f64 {
        1.875 * 3.0_f64.sqrt()
    }
}
