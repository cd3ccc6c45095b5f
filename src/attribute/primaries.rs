//! The primaries of scene-linear colours in files. All that is computed here is in Rec.709's.

use super::LinearRgb;

/// What the red, green and blue of scene-linear colours are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primaries {
    /// Rec.709, which sRGB has too.
    Rec709,
    /// AP1 of ACES under its own white: ACEScg.
    Ap1,
    /// Rec.2020.
    Rec2020,
}

/// Rec.709 to AP1, its white adapted from D65 to that of ACES by Bradford's matrix, as OpenColorIO does.
const TO_AP1: [[f64; 3]; 3] = [
    [0.613_097_402_41, 0.339_523_148_98, 0.047_379_448_61],
    [0.070_193_722_46, 0.916_353_876_86, 0.013_452_400_68],
    [0.020_615_592_94, 0.109_569_773_38, 0.869_814_633_68],
];

/// Rec.709 to Rec.2020: both have D65 (ITU-R BT.2087).
const TO_REC2020: [[f64; 3]; 3] = [
    [0.627_403_895_93, 0.329_283_038_38, 0.043_313_065_69],
    [0.069_097_289_36, 0.919_540_395_08, 0.011_362_315_57],
    [0.016_391_438_88, 0.088_013_307_88, 0.895_595_253_24],
];

impl Primaries {
    /// All, by the names that OpenColorIO, OpenEXR and USD have for them (`colorInteropID`).
    pub const NAMES: [(&'static str, Self); 3] =
        [("lin_rec709_scene", Self::Rec709), ("lin_ap1_scene", Self::Ap1), ("lin_rec2020_scene", Self::Rec2020)];

    /// Those of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.into_iter().find(|(known, _)| *known == name).map(|(_, primaries)| primaries)
    }

    /// Their name.
    pub fn name(self) -> &'static str {
        Self::NAMES.into_iter().find(|(_, known)| *known == self).map_or("", |(name, _)| name)
    }

    fn matrix(self) -> Option<glam::DMat3> {
        let rows = match self {
            Self::Rec709 => return None,
            Self::Ap1 => TO_AP1,
            Self::Rec2020 => TO_REC2020,
        };
        Some(glam::DMat3::from_cols_array_2d(&rows).transpose())
    }

    /// A colour of Rec.709 in these. None becomes negative: Rec.709 lies within the others.
    pub fn of_rec709(self, colour: LinearRgb) -> LinearRgb {
        changed(self.matrix(), colour)
    }

    /// A colour of these in Rec.709, which may be negative.
    pub fn to_rec709(self, colour: LinearRgb) -> LinearRgb {
        changed(self.matrix().map(|matrix| matrix.inverse()), colour)
    }
}

fn changed(matrix: Option<glam::DMat3>, colour: LinearRgb) -> LinearRgb {
    match matrix {
        Some(matrix) => (matrix * glam::DVec3::from(colour.map(f64::from))).as_vec3().to_array(),
        None => colour,
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    /// From places in the xy diagram: the columns are XYZ of red, green and blue, whose sum is white.
    fn to_xyz(corners: [[f64; 2]; 3], white: [f64; 2]) -> DMat3 {
        let of = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let columns = DMat3::from_cols(of(corners[0]), of(corners[1]), of(corners[2]));
        let shares = columns.inverse() * of(white);
        columns * DMat3::from_diagonal(shares)
    }

    #[test]
    fn matrices_follow_from_the_primaries() {
        let d65 = [0.3127, 0.3290];
        let aces = [0.32168, 0.33767];
        let rec709 = to_xyz([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], d65);
        let rec2020 = to_xyz([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], d65);
        let ap1 = to_xyz([[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]], aces);
        let bradford = DMat3::from_cols_array_2d(&[
            [0.8951, 0.2664, -0.1614],
            [-0.7502, 1.7135, 0.0367],
            [0.0389, -0.0685, 1.0296],
        ])
        .transpose();
        let white = |[x, y]: [f64; 2]| bradford * DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let adapted = bradford.inverse() * DMat3::from_diagonal(white(aces) / white(d65)) * bradford;
        for (primaries, wanted) in
            [(Primaries::Rec2020, rec2020.inverse() * rec709), (Primaries::Ap1, ap1.inverse() * adapted * rec709)]
        {
            let off = primaries.matrix().expect("they differ") - wanted;
            let most = off.to_cols_array().into_iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            assert!(most < 2e-5, "{primaries:?}: {most}");
        }
    }

    #[test]
    fn colours_come_back() {
        for (name, primaries) in Primaries::NAMES {
            assert_eq!(Primaries::named(name), Some(primaries));
            for colour in [[0.8, 0.1, 0.05], [1.0, 1.0, 1.0], [0.0, 0.0, 2.5]] {
                let there = primaries.of_rec709(colour);
                assert!(there.iter().all(|part| *part >= 0.0), "{name}: {there:?}");
                let back = primaries.to_rec709(there);
                assert!(back.iter().zip(&colour).all(|(a, b)| (a - b).abs() < 1e-6), "{name}: {back:?}");
            }
            let white = primaries.of_rec709([1.0; 3]);
            assert!(white.iter().all(|part| (part - 1.0).abs() < 1e-6), "{name}: {white:?}");
        }
    }
}
