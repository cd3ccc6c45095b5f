//! Morphs as shapes: two shapes, measured and planned once, at any time of their morph.

use std::sync::Arc;

use crate::attribute::{ColourSpace, Straight};
use crate::distance::method::Request;
use crate::distance::nearest::Watch;
use crate::distance::octree;
use crate::field::{Aabb, Field};
use crate::morph::{
    self, Carry, Morph, MorphAttribute, MorphObject, Motion, Plane, Settings, Similarity, Transfer, Volume,
};
use crate::node::attributes::{Asked, TheColour};
use crate::node::cache::Cache;
use crate::node::extent::solid_box;
use crate::node::id::Stage;
use crate::node::keeping::Solid;
use crate::node::measured::{measured_or_kept, smallest_cell};
use crate::node::model::ShapeId;
use crate::node::painted::Paint;
use crate::node::profile::{leaves_the_plane, lift_it};
use crate::node::solid::Solids;
use crate::text::problem::Problem;

/// What can carry the shapes of a morph that is one.
pub(crate) const CARRIES: &[&str] = &["none", "centroid", "inertia"];

/// A morph, planned now or as the plan was kept by a key.
pub(crate) fn planned_or_kept(
    from: MorphObject,
    to: MorphObject,
    settings: Settings,
    kept: Option<(&Cache, [u8; 32])>,
) -> Result<Morph, morph::Error> {
    let Some((cache, key)) = kept else { return Morph::new(from, to, settings) };
    if let Some(plan) = cache.plan(key) {
        return Morph::with_plan(from, to, settings, plan);
    }
    let morph = Morph::new(from, to, settings)?;
    cache.keep_plan(key, morph.plan());
    Ok(morph)
}

impl Solids {
    /// The morph that a shape made by `morph` shows one time of.
    pub fn morphed(&mut self, id: ShapeId) -> Result<Arc<Morph>, Problem> {
        if let Some(known) = self.morphs.get(&id) {
            return Ok(Arc::clone(known));
        }
        let model = self.model();
        let shape = model.shape(id);
        let arguments = &shape.arguments;
        let operands = arguments.shapes("morph").expect("it must be there");
        let (from, one) = self.solid_of(operands[0])?;
        let (to, two) = self.solid_of(operands[1])?;
        let voxel = one.union(two).size().max_element() / self.resolution();
        let from = self.object(operands[0], from, one, voxel)?;
        let to = self.object(operands[1], to, two, voxel)?;
        let carry = match arguments.choice("carry").copied() {
            Some("centroid") => Carry::Centroid,
            Some("inertia") => Carry::Inertia,
            None if one.intersection(two).is_none() => Carry::Centroid,
            _ => Carry::None,
        };
        let constant = |key: &str| *arguments.constant(key).expect("it has a default");
        let settings = Settings {
            mode: Arc::new(Volume { bridge: constant("bridge").into(), ..Volume::default() }),
            carry,
            alpha: constant("alpha").into(),
            beta: constant("beta").into(),
            colour_space: arguments
                .choice("color_space")
                .and_then(|name| ColourSpace::named(name))
                .unwrap_or(ColourSpace::Auto),
            plane: shape.is_flat.then(|| Plane::new(1.0, &Similarity::IDENTITY)),
            ..Settings::default()
        };
        let kept = self.keeping().and_then(|keeping| {
            Some((keeping.cache(), keeping.key(Solid::Stage(id, Stage::Own), None, "plan", &[voxel])?))
        });
        let morph = planned_or_kept(from, to, settings, kept).map_err(|error| {
            Problem::new(arguments.span("morph").unwrap_or(shape.span), format!("`{}`: {error}", shape.name))
        })?;
        Ok(Arc::clone(self.morphs.entry(id).or_insert(Arc::new(morph))))
    }

    /// An operand where it stands, and its box.
    fn solid_of(&mut self, id: ShapeId) -> Result<(Arc<dyn Field>, Aabb), Problem> {
        let model = self.model();
        if model.shape(id).is_flat {
            let help = || format!("turn it about z alone, or {} first", lift_it());
            let leaves = || leaves_the_plane(model.shape(id)).help(help());
            return self.in_plane(id, Stage::Placed)?.ok_or_else(leaves);
        }
        let surface = self.field(id, Stage::Placed)?;
        let solid = solid_box(&model, id, surface.as_ref())?;
        Ok((surface, solid))
    }

    /// An operand with its distance everywhere, as the objects of the scene's own morph have it.
    fn object(
        &mut self,
        id: ShapeId,
        surface: Arc<dyn Field>,
        solid: Aabb,
        voxel: f64,
    ) -> Result<MorphObject, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let cell = smallest_cell(voxel, &solid);
        let settings = shape.distance.settings(octree::Settings::new(solid, cell));
        let request = Request { field: &surface, solid, detail: cell, settings };
        let watch = Watch { cancel: self.cancel(), progress: &|_| {} };
        let distance = if shape.is_flat {
            shape.distance.method().measure_in_plane(&request, &watch).map(|measured| measured.distance)
        } else {
            let kept = self.keeping().map(|keeping| (keeping, Solid::Stage(id, Stage::Placed), None));
            measured_or_kept(shape.distance, &request, kept, &[cell], &watch)
        };
        let distance = distance.map_err(|error| Problem::new(shape.span, format!("`{}`: {error}", shape.name)))?;
        let paint = self.paint(TheColour, id, Stage::Placed, voxel)?;
        let colour = paint.unwrap_or_else(|| Paint::solid(TheColour.absent())).attribute;
        Ok(MorphObject { surface, distance, colour, motion: Motion::default() })
    }

    /// An attribute of a shape made by `morph`; `None` where neither operand has it.
    pub(crate) fn morphed_paint<const N: usize, W: Asked<N>>(
        &mut self,
        what: W,
        id: ShapeId,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let model = self.model();
        let arguments = &model.shape(id).arguments;
        let operands = arguments.shapes("morph").expect("it must be there");
        let Some(paints) = self.two_paints(what, [operands[0], operands[1]], voxel)? else { return Ok(None) };
        let mix = self.number(arguments.number("mix").expect("it has a default"))?;
        let morph = self.morphed(id)?;
        Ok(Some(Paint::shared(what.morphed(&morph, mix, paints.map(|paint| paint.attribute)))))
    }

    /// An attribute of a `blend` with `mix`: by the weights of STTI, its time a number of the design (STTI, figure 13).
    pub(crate) fn transferred_paint<const N: usize, W: Asked<N>>(
        &mut self,
        what: W,
        id: ShapeId,
        voxel: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let arguments = &shape.arguments;
        let span = arguments.span("mix").unwrap_or(shape.span);
        let [one, two] = arguments.shapes("blend").map_or(&[][..], Vec::as_slice) else {
            let problem =
                Problem::new(span, "`mix` goes over from one shape to another, and `blend` has more than two");
            return Err(problem.help("blend two of them first: { blend = [\"a\", \"b\"] } is a shape too"));
        };
        let Some(paints) = self.two_paints(what, [*one, *two], voxel)? else { return Ok(None) };
        let of = |key: &str| arguments.number(key).map(|number| self.number(number)).transpose();
        let (mix, alpha) = (of("mix")?.unwrap_or(0.5), of("alpha")?.unwrap_or(0.3));
        let (_, first) = self.solid_of(*one)?;
        let (_, second) = self.solid_of(*two)?;
        let unit = first.union(second).size().length() / 2.0;
        let mut distance = |id: ShapeId| -> Result<Arc<dyn Field>, Problem> {
            Ok(Arc::new(self.distance_around(id, "mix", span, None)?))
        };
        let (first, second) = (distance(*one)?, distance(*two)?);
        let [from, to] = paints.map(|paint| paint.attribute);
        let transfer = Transfer { time: mix, alpha, beta: 0.5 };
        Ok(Some(Paint::of(MorphAttribute::new([first, second], [from, to], unit, transfer, Straight))))
    }

    /// What two shapes have, where either has any.
    fn two_paints<const N: usize, W: Asked<N>>(
        &mut self,
        what: W,
        shapes: [ShapeId; 2],
        voxel: f64,
    ) -> Result<Option<[Paint<N>; 2]>, Problem> {
        let [from, to] = shapes.map(|id| self.paint(what, id, Stage::Placed, voxel));
        let (from, to) = (from?, to?);
        if from.is_none() && to.is_none() {
            return Ok(None);
        }
        Ok(Some([from, to].map(|paint| paint.unwrap_or_else(|| Paint::solid(what.absent())))))
    }
}
