//! What F is at one place, node by node: where a value comes from, and where it stops being a distance.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use serde::Serialize;

use super::assets::Assets;
use super::attributes::{Asked, TheColour, TheScalar};
use super::id::{ShapeId, Stage};
use super::model::{Content, Model};
use super::solid::Solids;
use crate::attribute::LinearRgb;
use crate::field::{Aabb, BATCH, Field, Gradients, Points, Slope};
use crate::text::diagnostic::Diagnostics;
use crate::text::problem::Problem;

/// A field at one place.
#[derive(Clone, Debug, Serialize)]
pub struct Reading {
    /// The place, in the space of this node.
    pub at: [f64; 3],
    /// F, positive inside; `null` in JSON where it is not a number.
    pub value: f64,
    /// The length of its gradient.
    pub gradient: f64,
    /// What it says of itself: `exact`, `exact outside`, `exact inside`, or the greatest slope; nothing where it is unknown.
    pub declared: Option<String>,
    /// The distance to its surface, where F is that.
    pub distance: Option<f64>,
    /// What the distance is at least, where the greatest slope is known.
    pub at_least: Option<f64>,
    /// Whether the gradient is longer than declared, or F no number.
    pub is_wrong: bool,
    /// The least and greatest corner of its box.
    pub bounds: Option<[[f64; 3]; 2]>,
}

/// A node at one place, and what it is made of.
#[derive(Clone, Debug, Serialize)]
pub struct Probe {
    /// The name of its shape; of what is done to a shape that of the key.
    pub name: String,
    /// Its node.
    pub node: &'static str,
    /// Its field.
    #[serde(flatten)]
    pub reading: Reading,
    /// Its colour there, scene-linear; of whole shapes.
    pub colour: Option<LinearRgb>,
    /// Its attributes there by name; of whole shapes.
    pub attributes: BTreeMap<String, f32>,
    /// What it is made of.
    pub made_of: Vec<Probe>,
}

impl Reading {
    /// Reads a field.
    pub fn of(field: &dyn Field, at: DVec3) -> Self {
        let mut points = Points::new(at);
        points.push(glam::Vec3::ZERO);
        let mut gradients = Gradients::new();
        let mut evaluator = field.evaluator();
        evaluator.gradients(&points, &mut gradients);
        let gradient = f64::from(gradients.gradient(0).length());
        let value = field.reference(at);
        let slope = field.slope();
        let bound = match slope {
            Slope::Exact { .. } => Some(1.0),
            Slope::Lipschitz(bound) => Some(bound),
            Slope::Unknown => None,
        };
        let is_exact = match slope {
            Slope::Exact { outside, inside } => {
                if value > 0.0 {
                    inside
                } else {
                    outside
                }
            }
            _ => false,
        };
        /// Rounding of a gradient in 32 bits.
        const SLACK: f64 = 1e-3;
        Self {
            at: at.to_array(),
            value,
            gradient,
            declared: match slope {
                Slope::Exact { outside: true, inside: true } => Some("exact".into()),
                Slope::Exact { outside: true, inside: false } => Some("exact outside".into()),
                Slope::Exact { outside: false, inside: true } => Some("exact inside".into()),
                Slope::Exact { .. } => Some("slope ≤ 1".into()),
                Slope::Lipschitz(bound) => Some(format!("slope ≤ {}", bound as f32)),
                Slope::Unknown => None,
            },
            distance: is_exact.then_some(value.abs()),
            at_least: bound.filter(|bound| *bound > 0.0).map(|bound| value.abs() / bound),
            is_wrong: value.is_nan()
                || gradient.is_nan()
                || bound.is_some_and(|bound| gradient > bound * (1.0 + SLACK)),
            bounds: field.bounding_box().map(|Aabb { min, max }| [min.to_array(), max.to_array()]),
        }
    }
}

impl Model {
    /// What the shapes that are baked are at a place, at a frame: one, or the two of each morph; and what is worth saying
    /// about what they read and measured.
    ///
    /// # Errors
    /// Where a shape cannot be built.
    pub fn probe(self: &Arc<Self>, at: DVec3, frame: f64) -> Result<(Vec<Probe>, Diagnostics), Problem> {
        let all: Vec<ShapeId> = (0..self.shapes.len()).map(ShapeId).collect();
        let assets = Arc::new(Assets::load(self, &all, None)?);
        /// Voxels along the longest side, for what has to be measured.
        const RESOLUTION: f64 = 128.0;
        let cancel = Arc::new(AtomicBool::new(false));
        let mut solids = Solids::new(self, &assets, self.moment(frame), RESOLUTION, &cancel);
        let shapes: Vec<ShapeId> = match &self.content {
            Content::Shape(id) => vec![*id],
            Content::Morph(morphs) => {
                morphs.iter().map(|morph| morph.from).chain(morphs.last().map(|morph| morph.to)).collect()
            }
        };
        let probes = shapes.into_iter().map(|id| shape(&mut solids, id, at)).collect::<Result<_, _>>()?;
        let warnings = assets.warnings().into_iter().chain(solids.insides.take_warnings()).collect();
        Ok((probes, Diagnostics::new(warnings, self.sources.clone())))
    }
}

/// A shape where it stands.
fn shape(solids: &mut Solids, id: ShapeId, at: DVec3) -> Result<Probe, Problem> {
    let model = solids.model();
    let shape = model.shape(id);
    let reading = Reading::of(&solids.values(id)?, at);
    let placement = solids.placement(&shape.placement, Stage::Placed)?;
    let own = placement.inverse().transform_point3(at);
    let last = shape.modifiers.len();
    let made_of = if last == 0 { operands(solids, id, own)? } else { vec![step(solids, id, last, own)?] };
    let colour = sampled(solids, TheColour, id, at)?;
    let mut attributes = BTreeMap::new();
    for name in model.scalar_names() {
        if let Some([number]) = sampled(solids, TheScalar(name), id, at)? {
            attributes.insert(name.to_owned(), number);
        }
    }
    Ok(Probe { name: shape.name.clone(), node: shape.spec.key.name, reading, colour, attributes, made_of })
}

/// A shape in its own space with so many of its modifiers.
fn step(solids: &mut Solids, id: ShapeId, step: usize, at: DVec3) -> Result<Probe, Problem> {
    let model = solids.model();
    let spec = model.shape(id).spec_of(step);
    let reading = Reading::of(&*solids.step_field(id, step)?, at);
    let made_of = match step.checked_sub(1) {
        None => operands(solids, id, at)?,
        Some(before) => {
            let back = solids.bend(id, step)?.map_or(at, |bend| bend.back(at));
            vec![self::step(solids, id, before, back)?]
        }
    };
    Ok(Probe {
        name: spec.key.name.into(),
        node: spec.key.name,
        reading,
        colour: None,
        attributes: BTreeMap::new(),
        made_of,
    })
}

/// The shapes that a shape is made of.
fn operands(solids: &mut Solids, id: ShapeId, at: DVec3) -> Result<Vec<Probe>, Problem> {
    let model = solids.model();
    model.shape(id).arguments.all_shapes().map(|operand| shape(solids, operand, at)).collect()
}

/// The colour or an attribute of a shape at a place.
fn sampled<const N: usize>(
    solids: &mut Solids,
    asked: impl Asked<N>,
    id: ShapeId,
    at: DVec3,
) -> Result<Option<[f32; N]>, Problem> {
    /// About that of an object a few units wide.
    const VOXEL: f64 = 0.02;
    let Some(paint) = solids.paint(asked, id, Stage::Placed, VOXEL)? else { return Ok(None) };
    let mut points = Points::new(at);
    points.push(glam::Vec3::ZERO);
    let mut out = [[0.0; N]; BATCH];
    paint.attribute.sampler().sample(&points, &mut out);
    Ok(Some(out[0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{Source, load};
    use crate::text::Overrides;

    fn probed(text: &str, at: DVec3) -> Vec<Probe> {
        let source = Source::Text { name: "p.toml".into(), text: text.into(), folder: ".".into() };
        let model = Arc::new(load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}")));
        model.probe(at, 1.0).unwrap().0
    }

    #[test]
    fn what_is_worth_saying_comes_along() {
        let text = "[output]\nshape = 's'\n[shape.s]\nbox = 1\nattribute.way = { interior = ['tip'], lattice = 16 }\n\
                    [shape.tip]\nsphere = 0.1\nmove = [3, 0, 0]\n";
        let source = Source::Text { name: "p.toml".into(), text: text.into(), folder: ".".into() };
        let model = Arc::new(load(&source, &Overrides::default()).expect("a scene"));
        let (shapes, warnings) = model.probe(DVec3::ZERO, 1.0).unwrap();
        assert!((shapes[0].attributes["way"] - 2.9).abs() < 0.02, "{:?}", shapes[0].attributes);
        assert!(warnings.render(false).contains("all of `tip` is outside of `s`"));
    }

    #[test]
    fn a_tree_of_values() {
        let text = "[output]\nshape = 'u'\n[shape.u]\nunion = ['a', 'b']\n\
                    [shape.a]\nsphere = 1\nmove = [2, 0, 0]\nscale = 2\ncolor = 'red'\nattribute.heat = 'x + y'\n[shape.b]\nbox = 2\noffset = 0.5\n";
        let all = probed(text, DVec3::new(5.0, 0.0, 0.0));
        let [union] = &all[..] else { panic!("one shape is baked") };
        // R₀ of −1 and −3.5, which is no distance.
        let joined = -4.5 + (1.0_f64 + 3.5 * 3.5).sqrt();
        assert!(
            union.node == "union" && (union.reading.value - joined).abs() < 1e-9 && union.reading.distance.is_none()
        );
        let [a, b] = &union.made_of[..] else { panic!("two operands: {union:?}") };
        assert_eq!((a.name.as_str(), a.reading.value, a.colour), ("a", -1.0, Some([1.0, 0.0, 0.0])));
        // In its own space, x is 1.5 there.
        assert_eq!((a.attributes.get("heat"), b.attributes.len()), (Some(&1.5), 0));
        assert_eq!((a.reading.distance, a.reading.gradient), (Some(1.0), 1.0));
        // Its offset, and the box within that.
        assert_eq!((b.reading.value, b.made_of[0].node, b.made_of[0].made_of[0].node), (-3.5, "offset", "box"));
        assert_eq!(b.made_of[0].made_of[0].reading.value, -4.0);
    }

    #[test]
    fn what_is_steeper_than_declared_is_told() {
        let steep = "[shape.f]\nformula = '1 - x^2 - y^2 - z^2'\nbounds = 3\n";
        let all = probed(steep, DVec3::X);
        assert!(!all[0].reading.is_wrong && all[0].reading.declared.is_none() && all[0].reading.distance.is_none());
        assert!((all[0].reading.gradient - 2.0).abs() < 1e-6);
    }
}
