//! A model made ready, and what each of its frames is computed from.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::attribute::{Colour, Scalar};
use crate::distance::band::Feet;
use crate::distance::method::{Choice, Method, Request, Rough};
use crate::distance::nearest::Watch;
use crate::distance::octree::Settings;
use crate::distance::without::Keep;
use crate::field::{Aabb, Field, Interval};
use crate::grid::Lattice;
use crate::morph::{FrameReport, Movement, Stage};

use crate::node::assets::Assets;
use crate::node::displacement::{self, Displacement};
use crate::node::extent::box_of;
use crate::node::measured::measured;
use crate::node::model::{Content, Model, Morph, ScalarName, ShapeId};
use crate::node::solid::Solids;
use crate::node::source::Given;
use crate::node::variation::Variation;
use crate::shot::error::Error;
use crate::shot::level_sets::LevelSets;
use crate::shot::morphing::{Planned, shown_at};
use crate::shot::scenery::Scenery;
use crate::shot::scenery::scenery;
use crate::shot::stop::Stop;
use crate::shot::stop::unless_cancelled;
use crate::text::diagnostic::{Diagnostic, Diagnostics, listed};
use crate::text::frames::sampled_frames;
use crate::text::frames::{Shot, plain};
use crate::text::problem::Problem;
use crate::text::source::Span;

/// A model made ready: any frame can be had from it, in any order, from any thread.
pub struct Prepared {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// Half the band's width in voxels.
    pub half_width: f32,
    /// The box of F ≥ 0 over the whole shot, band not counted.
    pub extent: Aabb,
    /// What was noticed, with places in the scene.
    pub warnings: Diagnostics,
    pub(crate) model: Arc<Model>,
    /// All shapes that it is made from or painted by.
    pub(crate) parts: Vec<ShapeId>,
    pub(crate) assets: Arc<Assets>,
    pub(crate) variation: Variation,
    pub(crate) content: Ready,
    /// All that does not change, built.
    pub(crate) base: Solids,
    /// The in-betweens where OpenVDB makes them.
    pub(crate) level_sets: Option<LevelSets>,
    /// Whether what it is made of was measured for estimates only.
    pub(crate) roughly: bool,
    /// What the distances of frames are to.
    pub feet: Feet,
    /// Set to stop.
    pub(crate) cancel: Arc<AtomicBool>,
}

/// What frames are made from.
pub(crate) enum Ready {
    /// A shape that never changes.
    Still(Scenery),
    /// A shape that is built for each frame.
    Changing(ShapeId),
    /// A chain of morphs.
    Morph(Vec<Planned>),
}

/// All that a frame's grids are computed from.
#[derive(Clone)]
pub struct FrameContent {
    /// F, world units.
    pub field: Arc<dyn Field>,
    /// The colour; `None` where nothing in the scene has one, or its grid is not to be written.
    pub colour: Option<Arc<Colour>>,
    /// The scalars of the grids that are to be written, by their names, sorted.
    pub scalars: Vec<(String, Arc<Scalar>)>,
    /// How the surface moves; `None` where `vel` is not to be written.
    pub movement: Option<Movement>,
    /// Where to look for the band: the solid's box grown by the band.
    pub region: Aabb,
    /// Which pieces of the solid stay.
    pub keep: Keep,
    /// The frame's place in time.
    pub info: FrameInfo,
}

/// Numbers on a frame of a morph.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MorphReport {
    /// Its volume and what changed since the frame before.
    #[serde(flatten)]
    pub numbers: FrameReport,
    /// The farthest that the surface went since the frame before, world units, to a part of a cell of the morph's coarse
    /// grid; 0 in the shot's first.
    pub displacement: f64,
}

/// A frame's place in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInfo {
    /// The frame that was asked for.
    pub frame: i64,
    /// Scene time: 0 at the shot's first frame, 1 at its last.
    pub t: f64,
    /// Whether the frame lies outside of the shot, where the ends hold.
    pub outside_shot: bool,
}

impl Prepared {
    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Whether box, lattice and frames are only about what they will be, see [`Model::outlook`].
    pub fn is_rough(&self) -> bool {
        self.roughly
    }

    /// All that one frame is computed from, whatever other frames are asked for.
    pub fn frame(&self, frame: i64) -> Result<FrameContent, Error> {
        let lacking = self.model.lacking(Some(&[frame]));
        if !lacking.is_empty() {
            return Err(Error::Scene(lacking));
        }
        unless_cancelled(&self.cancel, self.content_of(frame))
    }

    fn content_of(&self, frame: i64) -> Result<FrameContent, Error> {
        let info = self.info(frame);
        let scenery = match &self.content {
            Ready::Still(scenery) => scenery.clone(),
            Ready::Changing(id) => self.changing(*id, frame).map_err(|problem| self.model.error(problem))?,
            Ready::Morph(planned) => {
                let planned = &planned[self.shown(frame as f64)];
                let whole = match self.by_openvdb(frame) {
                    Some(sets) => sets.field(frame).map_err(|stop| self.model.stopped(stop))?,
                    None => planned.morph.field(info.t),
                };
                let field = self.dressed(whole, planned, frame as f64).map_err(|stop| self.model.stopped(stop))?;
                let attributes =
                    self.morph_attributes(planned, frame as f64).map_err(|problem| self.model.error(problem))?;
                let (colour, scalars) = attributes;
                Scenery { field, colour, scalars }
            }
        };
        let margin = (f64::from(self.half_width) + 2.0) * self.lattice.voxel_size.get();
        let region = scenery.field.bounding_box().unwrap_or(self.extent).grown(margin);
        let keep = match &self.model.content {
            Content::Morph(morphs) => morphs[0].keep,
            Content::Shape(_) => Keep::ALL,
        };
        let Scenery { field, colour, scalars } = scenery;
        let mut movement = None;
        if self.model.output.writes("vel") {
            movement = Some(self.movement(frame).map_err(|stop| self.model.stopped(stop))?);
        }
        Ok(FrameContent { field, colour, scalars, movement, region, keep, info })
    }

    /// Numbers on a morph's frame and on the way to it from the one before, measured on the morph's coarse grid; `None`
    /// where the scene is no morph. The same whatever else is asked for.
    pub fn report(&self, frame: i64) -> Result<Option<MorphReport>, Error> {
        let Ready::Morph(planned) = &self.content else { return Ok(None) };
        let range = self.model.shot.range;
        let (frame, before) = (frame.clamp(range.first, range.last), (frame - 1).clamp(range.first, range.last));
        let [from, to] = [before, frame].map(|frame| range.share(frame as f64));
        // A chain's object at its own frame is the end of the morph to it.
        let morph = &planned[self.shown(before as f64)].morph;
        if let Some(sets) = self.by_openvdb(frame) {
            let distance =
                |frame| sets.distance(frame, morph.plan().grid.edge()).map_err(|stop| self.model.stopped(stop));
            let (before, now) = (distance(before)?, distance(frame)?);
            let (numbers, displacement) = morph.report_of(to, [&before, &now].map(Option::as_deref));
            return Ok(Some(MorphReport { numbers, displacement }));
        }
        let Some(numbers) = morph.report(&[from, to]).frames.pop() else { return Ok(None) };
        let displacement = if before == frame { 0.0 } else { morph.displacement(from, to) };
        Ok(Some(MorphReport { numbers, displacement }))
    }

    /// The volume that changed from one frame of a morph that moves to another, seen from a frame that moves with it;
    /// `None` where the scene is none such. Of frames in several morphs of a chain the sum of what each changes.
    pub fn change_of_shape(&self, before: i64, frame: i64) -> Option<f64> {
        let (Content::Morph(morphs), Ready::Morph(planned)) = (&self.model.content, &self.content) else { return None };
        if self.level_sets.is_some() || !planned.iter().any(|planned| planned.morph.moves()) {
            return None;
        }
        let links = [before, frame].map(|frame| self.shown(frame as f64));
        let of_link = |link: usize| {
            let from = if link == links[0] { before } else { morphs[link].over.first };
            let to = if link == links[1] { frame } else { morphs[link + 1].over.first };
            let times = [from, to].map(|frame| self.model.shot.range.share(frame as f64).clamp(0.0, 1.0));
            planned[link].morph.report(&times).frames.pop().map(|report| report.change)
        };
        (links[0]..=links[1]).map(of_link).sum()
    }

    /// Whether a frame is made without those before it: all but those that OpenVDB makes.
    pub fn is_made_alone(&self, frame: i64) -> bool {
        self.by_openvdb(frame).is_none()
    }

    /// What a frame is made by where OpenVDB makes it.
    fn by_openvdb(&self, frame: i64) -> Option<&LevelSets> {
        self.level_sets.as_ref().filter(|sets| sets.show(frame))
    }

    /// Which morph of a chain a frame shows.
    pub(crate) fn shown(&self, frame: f64) -> usize {
        match &self.model.content {
            Content::Morph(morphs) => shown_at(morphs, frame),
            Content::Shape(_) => 0,
        }
    }

    /// A morph's field with its surface moved, filled, and without what is to be taken away.
    pub(crate) fn dressed(
        &self,
        mut whole: Arc<dyn Field>,
        planned: &Planned,
        frame: f64,
    ) -> Result<Arc<dyn Field>, Stop> {
        let Content::Morph(morphs) = &self.model.content else { return Ok(whole) };
        let Morph { displace, fill, cut, .. } = &morphs[0];
        if let Some(by) = displace {
            whole = self.displaced(whole, by, planned, frame)?;
        }
        if fill.is_none() && cut.is_none() {
            return Ok(whole);
        }
        let mut solids = self.base.at(self.model.moment(frame), &self.variation);
        if let Some(fill) = fill
            && let Some(omega) = self.morph_scalar(planned, &fill.by.name, frame)?
        {
            whole = solids.filled(whole, fill, omega, self.extent.size().max_element())?;
        }
        match cut {
            Some(cut) => Ok(solids.without(whole, *cut)?),
            None => Ok(whole),
        }
    }

    fn displaced(
        &self,
        whole: Arc<dyn Field>,
        by: &ScalarName,
        planned: &Planned,
        frame: f64,
    ) -> Result<Arc<dyn Field>, Stop> {
        // What is empty has no surface to move, and what is endless is said elsewhere.
        let Ok(solid) = box_of(whole.as_ref()) else { return Ok(whole) };
        let Some(displacement) = self.displacement(solid, by, planned, frame)? else { return Ok(whole) };
        let time = self.model.shot.range.share(frame);
        let end = match planned.morph.stage(time) {
            _ if self.roughly || planned.morph.is_of_plane() => None,
            _ if self.by_openvdb(frame as i64).is_some() => None,
            Stage::From => Some(&planned.from),
            Stage::To => Some(&planned.to),
            _ => None,
        };
        // One of the objects, as it is.
        if let Some(end) = end {
            let mut solids = self.base.at(self.model.moment(frame), &self.variation);
            let moved = solids.moved(end.id, &displacement)?;
            return Ok(moved.unwrap_or_else(|| displacement.of_field(planned.morph.moving_field(time))));
        }
        let voxel = self.lattice.voxel_size.get();
        let problem = |error: String| Problem::new(by.span, format!("frame {}: {error}", plain(frame)));
        let distance = if self.roughly {
            let settings = Settings::new(solid, voxel);
            let request = Request { field: &whole, solid, detail: voxel, settings };
            Rough
                .measure(&request, &Watch { cancel: &self.cancel, progress: &|_| {} })
                .map(|measured| measured.distance)
        } else {
            measured(Choice::USUAL, &whole, solid, Interval::ZERO, voxel, None, &self.cancel)
        };
        let distance = distance.map_err(|error| Stop::of_measuring(&error, problem))?;
        Ok(displacement.of_field(distance))
    }

    fn displacement(
        &self,
        solid: Aabb,
        by: &ScalarName,
        planned: &Planned,
        frame: f64,
    ) -> Result<Option<Displacement>, Problem> {
        let Some(scalar) = self.morph_scalar(planned, &by.name, frame)? else { return Ok(None) };
        let displacement = Displacement::new(scalar, solid);
        let displacement = displacement.ok_or_else(|| displacement::no_greatest(by.span, &by.name, "morph"))?;
        Ok(Some(displacement))
    }

    /// The farthest outward that `displace` moves any frame of a morph, world units; 0 where nothing does.
    pub(crate) fn greatest_displacement(&self) -> Result<f64, Problem> {
        let (Content::Morph(morphs), Ready::Morph(planned)) = (&self.model.content, &self.content) else {
            return Ok(0.0);
        };
        let Some(by) = &morphs[0].displace else { return Ok(0.0) };
        let mut greatest: f64 = 0.0;
        for frame in sampled_frames(self.model.shot.range) {
            let found = self.displacement(self.extent, by, &planned[self.shown(frame)], frame)?;
            greatest = greatest.max(found.map_or(0.0, |displacement| displacement.reach()));
        }
        Ok(greatest)
    }

    fn changing(&self, id: ShapeId, frame: i64) -> Result<Scenery, Problem> {
        let mut solids = self.base.at(self.model.moment(frame as f64), &self.variation);
        scenery(&mut solids, id, &self.lattice)
    }

    fn info(&self, frame: i64) -> FrameInfo {
        let Shot { range, .. } = self.model.shot;
        FrameInfo { frame, t: range.share(frame as f64), outside_shot: !(range.first..=range.last).contains(&frame) }
    }

    /// A problem with the distances that are written, as an error that points to what measures them.
    pub fn distance_problem(&self, problem: String) -> Error {
        let place = self.model.written_distance_span();
        let problem = match place {
            Some(span) => Diagnostic::error(span, problem),
            None => Diagnostic::without_place(problem),
        };
        self.model.error(Problem(Box::new(problem)))
    }

    /// A problem with a value of a grid, the colour's or a scalar's, as an error that points to the formulas it can come
    /// from, or to what could not be measured; `None` where none of them is either.
    pub fn attribute_problem(&self, grid: &str, problem: &str) -> Option<Error> {
        if let Some(failure) = self.base.failure().get() {
            return Some(self.model.error(failure.clone()));
        }
        let is_colour = grid == self.model.output.colour_name;
        let span = |id: ShapeId| {
            let shape = self.model.shape(id);
            let scalar = shape.scalars.get(grid).and_then(Given::formula);
            if is_colour { shape.colour.as_ref().and_then(Given::formula) } else { scalar }
        };
        let named = |id: &ShapeId| Some((self.model.shape(*id).name.clone(), span(*id)?));
        let found: Vec<(String, Span)> = self.parts.iter().filter_map(named).collect();
        let help = "keep its formulas from dividing by 0, and from roots and logarithms of negative numbers";
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        let problem = match found.as_slice() {
            [] => return None,
            [(_, span)] => Diagnostic::error(*span, problem).help(help),
            [(_, span), ..] => {
                Diagnostic::error(*span, problem).help(format!("it is that of one of {}; {help}", listed(&names)))
            }
        };
        Some(self.model.error(Problem(Box::new(problem))))
    }

    /// About how much memory the prepared scene itself holds, in bytes: frames come on top.
    pub fn memory_estimate(&self) -> u64 {
        let (mut distances, mut of_frame) = (0, 0);
        if let (Ready::Morph(planned), Content::Morph(morphs)) = (&self.content, &self.model.content) {
            distances = planned.iter().map(|planned| planned.bytes).sum();
            if morphs[0].displace.is_some() {
                // The frame is measured too: about as much as one of its objects, and one more frame may be under way.
                of_frame = planned.iter().map(|planned| planned.bytes).max().unwrap_or(0);
            }
        }
        let level_sets = self.level_sets.as_ref().map_or(0, LevelSets::bytes);
        let insides = self.base.insides.bytes() as u64;
        self.assets.bytes() + distances + of_frame + level_sets + insides
    }
}
