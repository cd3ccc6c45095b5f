//! Where a grid's voxels stand in the world.

use glam::{DMat4, DVec3, DVec4, IVec3};

use super::cursor::{Cursor, Failure, damage};

/// From voxels to the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Transform {
    /// An affine map: world = matrix · voxel, column vectors.
    Affine(DMat4),
    /// A camera's frustum: voxels grow with the distance.
    Frustum,
}

impl Transform {
    /// The lengths of a voxel's edges in world units, `None` in a frustum.
    pub fn voxel_size(&self) -> Option<DVec3> {
        match self {
            Self::Affine(matrix) => {
                Some(DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length()))
            }
            Self::Frustum => None,
        }
    }

    /// The voxel's edge where voxels are cubes along the world's axes, turned nowhere and mirrored nowhere.
    pub fn uniform_voxel_size(&self) -> Option<f64> {
        let Self::Affine(matrix) = self else { return None };
        let size = matrix.x_axis.x;
        let cubes = DMat4::from_cols(
            DVec4::new(size, 0.0, 0.0, 0.0),
            DVec4::new(0.0, size, 0.0, 0.0),
            DVec4::new(0.0, 0.0, size, 0.0),
            matrix.w_axis,
        );
        (size > 0.0 && *matrix == cubes).then_some(size)
    }

    /// The world position of a voxel's centre, `None` in a frustum.
    pub fn world(&self, voxel: DVec3) -> Option<DVec3> {
        match self {
            Self::Affine(matrix) => Some(matrix.transform_point3(voxel)),
            Self::Frustum => None,
        }
    }

    /// The box in the world around the centres of a box of voxels, the least and the greatest given; `None` in a frustum.
    pub fn world_box(&self, low: IVec3, high: IVec3) -> Option<[[f64; 3]; 2]> {
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for corner in 0..8 {
            let pick = |axis: usize| f64::from(if corner >> axis & 1 == 0 { low[axis] } else { high[axis] });
            let world = self.world(DVec3::new(pick(0), pick(1), pick(2)))?;
            let (least, greatest) = bounds.unwrap_or((world, world));
            bounds = Some((least.min(world), greatest.max(world)));
        }
        bounds.map(|(least, greatest)| [least.to_array(), greatest.to_array()])
    }
}

/// OpenVDB keeps, beside a scale, four vectors derived from it.
const DERIVED: usize = 4;

pub fn read(cursor: &mut Cursor) -> Result<Transform, Failure> {
    let at = cursor.at();
    let kind = cursor.string()?;
    let transform = match kind.as_str() {
        "TranslationMap" => Transform::Affine(DMat4::from_translation(vector(cursor)?)),
        "ScaleMap" | "UniformScaleMap" => Transform::Affine(DMat4::from_scale(scale(cursor)?)),
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let translation = vector(cursor)?;
            Transform::Affine(DMat4::from_translation(translation) * DMat4::from_scale(scale(cursor)?))
        }
        "AffineMap" | "UnitaryMap" => Transform::Affine(matrix(cursor)?),
        "NonlinearFrustumMap" => {
            cursor.take(8 * 8)?; // the box, the taper, the depth
            let inner_at = cursor.at();
            let inner = cursor.string()?;
            if inner != "AffineMap" {
                return damage(inner_at, format!("a frustum stands on a map '{inner}'"));
            }
            matrix(cursor)?;
            Transform::Frustum
        }
        other => return damage(at, format!("'{other}' is no map that OpenVDB knows")),
    };
    match transform {
        Transform::Affine(matrix) if !(matrix.is_finite() && matrix.determinant() != 0.0) => {
            damage(at, "the transform is flat, or not a number")
        }
        sound => Ok(sound),
    }
}

fn vector(cursor: &mut Cursor) -> Result<DVec3, Failure> {
    Ok(DVec3::new(cursor.f64()?, cursor.f64()?, cursor.f64()?))
}

fn scale(cursor: &mut Cursor) -> Result<DVec3, Failure> {
    let scale = vector(cursor)?;
    cursor.take(DERIVED * 24)?;
    Ok(scale)
}

/// OpenVDB multiplies row vectors and stores rows: its rows are our columns.
fn matrix(cursor: &mut Cursor) -> Result<DMat4, Failure> {
    let mut columns = [0.0; 16];
    for entry in &mut columns {
        *entry = cursor.f64()?;
    }
    Ok(DMat4::from_cols_array(&columns))
}
