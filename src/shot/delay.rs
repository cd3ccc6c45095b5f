//! A morph's delay, as the morph takes it.

use std::sync::Arc;

use crate::attribute::{Attribute, FieldValue, LUMINANCE, Sampler, Scalar};
use crate::field::{Aabb, BATCH, Points};
use crate::morph;

use crate::node::attributes::{TheColour, TheScalar};
use crate::node::id::Stage;
use crate::node::model::{Component, DelaySource, Model, Morph, MorphDelay};
use crate::node::solid::Solids;
use crate::text::problem::Problem;

/// How long places of a morph wait; `None` where none does. `voxel` is a voxel's edge.
pub(crate) fn delay(
    model: &Arc<Model>,
    solids: &mut Solids,
    morph: &Morph,
    voxel: f64,
) -> Result<Option<morph::Delay>, Problem> {
    let Some(MorphDelay { source, span }) = morph.mode.delay() else { return Ok(None) };
    let scalar: Arc<Scalar> = match source {
        DelaySource::Space(component) => {
            if matches!(component, Component::Formula(formula) if model.formula_varies(formula)) {
                let problem = "`morph.delay` changes over time, and must stand still";
                return Err(
                    Problem::new(*span, problem).help("a formula of x, y, z; `ease` changes the pace over time")
                );
            }
            Arc::new(FieldValue(solids.component(None, component, Vec::new())?))
        }
        DelaySource::Shape { shape, attribute, most } => {
            let missing = |what: &str| {
                let name = &model.shape(*shape).name;
                Problem::new(*span, format!("`{name}` has no {what} for `morph.delay`"))
            };
            match attribute {
                Some(name) => {
                    let paint = solids.paint(TheScalar(name), *shape, Stage::Placed, voxel)?;
                    let inner = paint.ok_or_else(|| missing(&format!("`attribute.{name}`")))?.attribute;
                    Arc::new(Sum { inner, weights: [*most] })
                }
                None => {
                    let paint = solids.paint(TheColour, *shape, Stage::Placed, voxel)?;
                    let inner = paint.ok_or_else(|| missing("colour"))?.attribute;
                    Arc::new(Sum { inner, weights: LUMINANCE.map(|weight| weight * most) })
                }
            }
        }
    };
    Ok(Some(morph::Delay(scalar)))
}

/// The weighed sum of an attribute's numbers.
struct Sum<const N: usize> {
    inner: Arc<dyn Attribute<N>>,
    weights: [f64; N],
}

impl<const N: usize> Attribute<1> for Sum<N> {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(SumSampler { inner: self.inner.sampler(), weights: self.weights, values: [[0.0; N]; BATCH] })
    }
}

struct SumSampler<'a, const N: usize> {
    inner: Box<dyn Sampler<N> + 'a>,
    weights: [f64; N],
    values: [[f32; N]; BATCH],
}

impl<const N: usize> Sampler<1> for SumSampler<'_, N> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(region);
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        self.inner.sample(points, &mut self.values);
        for (out, values) in out[..points.len].iter_mut().zip(&self.values) {
            out[0] =
                values.iter().zip(self.weights).map(|(value, weight)| f64::from(*value) * weight).sum::<f64>() as f32;
        }
    }
}
