//! A whole morph: planned once, then any instant of it by itself.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::carry::{Untold, Way};
use super::coarse::{CoarseGrid, Measured};
use super::common::Common;
use super::course::{Course, LEAST_TIME, Timed};
use super::delay::DelayGrid;
use super::delayed::DelayedStb;
use super::error::{Error, Side};
use super::mode::{self, Between, Pace, Placed};
use super::motion::{Moved, Similarity};
use super::object::MorphObject;
use super::pace::{Curve, Even, even};
use super::recent::Recent;
use super::section::{Kernel, Section};
use super::settings::{Ease, Settings};
use super::stb::Stb;
use super::stti::{MorphAttribute, Transfer};
use super::surfels::Surfels;
use super::volume::{Enclosing, Volume, difference, object_cells, object_fractions, place_fractions, total};
use crate::attribute::{Attribute, Colour, LinearRgb, Mix, Mixer, Turn};
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Field, Interval, Points};

/// Steps of t's curve. Fewer miss short bursts of change; each costs a solve on the coarse grid in each pass.
const STEPS: usize = 40;
/// Steps at which a moving object's box is taken, and the coarse grid's where it moves.
const BOX_STEPS: usize = 160;
/// Cells of the coarse grid across the longer object, at least. Fewer miss a tenth of the volume of one that moves.
const LEAST_ACROSS: f64 = 6.0;
/// The coarse grid's margin around both objects, in units of D: first tried, and the most tried before giving up.
const MARGINS: [f64; 2] = [0.15, 2.5];

/// What is worked out once for a morph: the same for every frame, resolution and number of threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// D, world units: half the diagonal of the box around both objects while the shape changes, in the frame that moves
    /// with them.
    pub unit: f64,
    /// Where volume and change are measured, in that frame.
    pub grid: CoarseGrid,
    /// STB's time t over the morph's eased progress, both in \[0, 1\].
    pub pace: Curve,
    /// The change of volume from each of the plan's steps to the next, cubic world units, if nothing waited.
    pub changes: Vec<f64>,
    /// The least and greatest corner of the box of F ≥ 0 over all steps, to within a cell of the coarse grid.
    pub extent: [[f64; 3]; 2],
    /// The way round between nearly opposite hues: that of the objects' mean colours.
    pub turn: Turn,
}

/// What a morph shows at one scene time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// The object at the start, as it is.
    From,
    /// What is between them at this t of STB.
    Between(f64),
    /// The object at the end, as it is.
    To,
}

impl Stage {
    /// STB's time.
    pub fn t(&self) -> f64 {
        match self {
            Self::From => 0.0,
            Self::Between(t) => *t,
            Self::To => 1.0,
        }
    }
}

/// Two objects, and how one becomes the other.
pub struct Morph {
    pub(super) from: MorphObject,
    pub(super) to: MorphObject,
    pub(super) settings: Settings,
    pub(super) plan: Plan,
    /// The way that the objects are carried along, which their motions here follow.
    pub(super) way: Option<Arc<Way>>,
    /// Where the frame that moves with both objects stands in the world, and the coarse grid with it.
    pub(super) common: Common,
    /// The coarse grid's distances, where both objects rest in that frame.
    pub(super) still: Option<Arc<Measured>>,
    /// Where the shape waits.
    pub(super) delay: Option<Arc<DelayGrid>>,
    courses: Recent<Course>,
    /// What the blend encloses, and the surface on the coarse grid: each wanted by a frame and by the one after it.
    pub(super) solved: Recent<Solved>,
    pub(super) surfels: Recent<Surfels>,
}

/// The blend at one scene time, as the coarse grid knows it.
pub(super) struct Solved {
    /// The amount, and what it encloses.
    pub enclosing: Enclosing,
    /// The volume that it is to enclose, in cells.
    pub target: f64,
}

impl Morph {
    /// Checks the settings and plans the morph: the one slow step, a second or two.
    pub fn new(from: MorphObject, to: MorphObject, settings: Settings) -> Result<Self, Error> {
        settings.check()?;
        let (objects, way, common) = carried([from, to], &settings)?;
        let over = |object: &MorphObject, side: Side| {
            let own = object.own_box();
            let placement = |time: f64| object.motion.at(time).seen_from(&common.motion.at(time));
            Ok(box_over(own.ok_or(Error::Unbounded(side))?, &settings, common.rests, placement))
        };
        let boxes = [over(&objects[0], Side::From)?, over(&objects[1], Side::To)?];
        let both = boxes[0].union(boxes[1]);
        let unit = both.size().length() * 0.5;
        let height = settings.plane.map(|plane| plane.height);
        let (mut margin, mut spreads) = (MARGINS[0], [0.0; 2]);
        while margin <= MARGINS[1] {
            let grid = CoarseGrid::over(both.grown(margin * unit), height);
            let across = objects.iter().map(|object| {
                let longest = object.own_box().map_or(0.0, Aabb::longest_side);
                longest * object.motion.at(settings.over[0]).scale() / grid.edge()
            });
            let across = across.fold(0.0, f64::max);
            if across < LEAST_ACROSS {
                return Err(Error::Far(across));
            }
            let plan =
                Plan { unit, grid, pace: Curve::line(), changes: Vec::new(), extent: [[0.0; 3]; 2], turn: Turn::Up };
            let mut morph = Self::planned(objects.clone(), settings.clone(), plan, way.clone(), common.clone());
            let Some(at) = morph.make_plan()? else { return Ok(morph) };
            spreads = at;
            margin *= 2.0;
        }
        let [time, t] = spreads;
        Err(Error::Spreads { time, t })
    }

    /// A morph whose plan was made before, from the same objects and settings but for their colours.
    pub fn with_plan(from: MorphObject, to: MorphObject, settings: Settings, plan: Plan) -> Result<Self, Error> {
        settings.check()?;
        let (objects, way, common) = carried([from, to], &settings)?;
        let mut morph = Self::planned(objects, settings, plan, way, common);
        morph.measure_still();
        morph.measure_delay()?;
        let ends = morph.settings.shares_of(&[0.0, 1.0]).into_iter().map(|share| morph.settings.time_of(share));
        let ends: Vec<Arc<Measured>> = ends.map(|time| morph.measured_at(time)).collect();
        morph.plan.turn = morph.turn(&ends[0].first, &ends[1].second);
        Ok(morph)
    }

    /// Of these parts, with nothing measured yet.
    pub(super) fn planned(
        [from, to]: [MorphObject; 2],
        settings: Settings,
        plan: Plan,
        way: Option<Arc<Way>>,
        common: Common,
    ) -> Self {
        let (courses, solved, surfels) = (Recent::new(), Recent::new(), Recent::new());
        Self { from, to, settings, plan, way, common, still: None, delay: None, courses, solved, surfels }
    }

    /// What was planned.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What the way that carries the objects leaves out, as nothing decides it.
    pub fn untold(&self) -> &[Untold] {
        self.way.as_ref().map_or(&[], |way| &way.untold)
    }

    /// Whether the objects are carried along a way.
    pub fn is_carried(&self) -> bool {
        self.way.is_some()
    }

    /// Whether it moves as it changes, so that change of shape is not all change.
    pub fn moves(&self) -> bool {
        !self.common.motion.is_still()
    }

    /// The box of F ≥ 0 while the shape changes, to within a cell of the coarse grid.
    pub fn extent(&self) -> Aabb {
        let [min, max] = self.plan.extent;
        Aabb::new(DVec3::from_array(min), DVec3::from_array(max))
    }

    /// What the morph shows at scene time τ.
    pub fn stage(&self, time: f64) -> Stage {
        match self.time_at(time) {
            t if t <= 0.0 => Stage::From,
            t if t >= 1.0 => Stage::To,
            t => Stage::Between(t),
        }
    }

    /// The frame's field in world units, at scene time τ. At the ends it is the object's own; shapes of the plane are
    /// extruded.
    pub fn field(&self, time: f64) -> Arc<dyn Field> {
        self.extruded(self.profile(time), time)
    }

    /// The same before it is extruded: where the objects are shapes of the plane, a field that does not know how far from it
    /// a point is.
    pub fn profile(&self, time: f64) -> Arc<dyn Field> {
        let own = |object: &MorphObject| -> Arc<dyn Field> {
            Arc::new(Moved::new(object.surface.clone(), object.motion.at(time)))
        };
        let distance = |object: &MorphObject| -> Arc<dyn Distance> {
            Arc::new(Moved::new(object.distance.clone(), object.motion.at(time)))
        };
        let stb = |section: &Section| -> Arc<dyn Field> {
            Arc::new(Stb::new(distance(&self.from), distance(&self.to), self.plan.unit, section))
        };
        let t = match self.stage(time) {
            Stage::From => return own(&self.from),
            Stage::To => return own(&self.to),
            Stage::Between(t) => t,
        };
        if let Some(field) = self.delayed_field(time, || [distance(&self.from), distance(&self.to)]) {
            return field;
        }
        match self.settings.mode.between(t, time) {
            Between::Section(section) => stb(&section),
            Between::Enclosing(section) => stb(&Section { a0: self.solved(time).enclosing.a0, ..section }),
            Between::Formula(formula) => formula.field(&Placed {
                distances: [distance(&self.from), distance(&self.to)],
                surfaces: [own(&self.from), own(&self.to)],
            }),
        }
    }

    /// The frame's colour at scene time τ. Where shape and colour are both at an end, it is the object's own.
    pub fn colour(&self, time: f64) -> Arc<Colour> {
        self.colour_of(time, None, None)
    }

    /// As [`Morph::colour`], with other colours of the two objects at that time, in their own spaces, where given.
    pub fn colour_of(&self, time: f64, from: Option<Arc<Colour>>, to: Option<Arc<Colour>>) -> Arc<Colour> {
        let own = |object: &MorphObject| object.colour.clone();
        let (from, to) = (from.unwrap_or_else(|| own(&self.from)), to.unwrap_or_else(|| own(&self.to)));
        self.attribute(time, from, to, Mixer::new(self.settings.colour_space, self.plan.turn))
    }

    /// An attribute of the frame at scene time τ, from what it is on the two objects at that time, in their own spaces;
    /// by the weights of colours.
    pub fn attribute<const N: usize>(
        &self,
        time: f64,
        from: Arc<dyn Attribute<N>>,
        to: Arc<dyn Attribute<N>>,
        mix: impl Mix<N> + 'static,
    ) -> Arc<dyn Attribute<N>> {
        let colour_time = self.colour_time(time);
        let from = Moved::new(from, self.from.motion.at(time));
        let to = Moved::new(to, self.to.motion.at(time));
        let distance = |object: &MorphObject| Moved::new(object.distance.clone(), object.motion.at(time));
        let t = self.time_at(time);
        if t <= 0.0 && colour_time <= 0.0 {
            return Arc::new(from);
        }
        if t >= 1.0 && colour_time == 1.0 {
            return Arc::new(to);
        }
        let Settings { alpha, beta, .. } = &self.settings;
        Arc::new(MorphAttribute {
            first: Arc::new(distance(&self.from)),
            second: Arc::new(distance(&self.to)),
            from: Arc::new(from),
            to: Arc::new(to),
            unit: self.plan.unit,
            transfer: Transfer { time: colour_time, alpha: alpha.at(time), beta: beta.at(time) },
            delay: self.delay.clone(),
            mix,
        })
    }

    /// STTI's time at scene time τ: even, 0 before its span, after it 1 or, with the octopus effect, on and on.
    fn colour_time(&self, time: f64) -> f64 {
        let [start, end] = self.settings.colour_over;
        let colour_time = ((time - start) / (end - start)).max(0.0);
        if self.settings.octopus { colour_time } else { colour_time.min(1.0) }
    }

    /// STB's t at scene time τ, in \[0, 1\].
    pub(super) fn time_at(&self, time: f64) -> f64 {
        if self.settings.mode.stays() { 0.0 } else { self.plan.pace.at(self.settings.eased(time)) }
    }

    fn paced(&self) -> bool {
        self.settings.mode.pace() == Pace::Even
    }

    /// The blend's amount at t and scene time τ, and what it encloses; at the ends, 0 and the object.
    pub(super) fn enclosing(&self, measured: &Measured, time: f64, t: f64) -> Enclosing {
        let (grid, unit) = (&self.plan.grid, self.plan.unit);
        let plain = |fractions| Enclosing { a0: 0.0, fractions };
        if t <= 0.0 {
            return plain(object_fractions(grid, &measured.first, unit));
        }
        if t >= 1.0 && !self.settings.mode.stays() {
            return plain(object_fractions(grid, &measured.second, unit));
        }
        match self.settings.mode.between(t, time) {
            Between::Section(section) => Volume::new(grid, measured, unit, section).as_it_is(),
            Between::Enclosing(section) => {
                Volume::new(grid, measured, unit, section).enclosing(self.target(measured, time, t))
            }
            Between::Formula(formula) => plain(formula.fractions(grid, measured, unit)),
        }
    }

    /// The blend at scene time τ.
    pub(super) fn solved(&self, time: f64) -> Arc<Solved> {
        self.solved.at(time, || {
            let (measured, t) = (self.measured_at(time), self.time_at(time));
            let enclosing = self.delayed(&measured, time, t).unwrap_or_else(|| self.enclosing(&measured, time, t));
            Solved { enclosing, target: self.target(&measured, time, t) }
        })
    }

    /// The volume at t and scene time τ, in cells.
    pub(super) fn target(&self, measured: &Measured, time: f64, t: f64) -> f64 {
        let own = |distances: &[f32]| object_cells(&self.plan.grid, distances, self.plan.unit);
        let (first, second) = (own(&measured.first), own(&measured.second));
        let factor = self.settings.mode.volume().map_or(1.0, |mode| mode.volume.at(time));
        ((1.0 - t) * first + t * second) * factor
    }

    /// What the blend encloses on the way where places wait.
    fn delayed(&self, measured: &Arc<Measured>, time: f64, t: f64) -> Option<Enclosing> {
        let (delay, mode) = (self.delay.as_ref()?, self.settings.mode.volume()?);
        if t <= 0.0 || t >= 1.0 {
            return None;
        }
        let (grid, eased) = (&self.plan.grid, self.settings.eased(time));
        let course = self.course(mode, delay, time, || Arc::clone(measured));
        let common = self.common.motion.at(time);
        let place = |cell: usize| course.place(delay.progress(common.to_world(grid.centre(cell)), eased));
        let fractions = place_fractions(grid, measured, self.plan.unit, place);
        Some(Enclosing { a0: course.a0(eased), fractions })
    }

    /// The field of places that wait; `None` where none does.
    fn delayed_field(&self, time: f64, pair: impl FnOnce() -> [Arc<dyn Distance>; 2]) -> Option<Arc<dyn Field>> {
        let (delay, mode) = (self.delay.as_ref()?, self.settings.mode.volume()?);
        let [first, second] = pair();
        let course = self.course(mode, delay, time, || self.measured_at(time));
        let (unit, eased, delay) = (self.plan.unit, self.settings.eased(time), Arc::clone(delay));
        Some(Arc::new(DelayedStb { first, second, unit, eased, delay, course }))
    }

    /// The sections with the objects as they stand at scene time τ, at all progress that places have then. `measured` is
    /// asked only where they are not known.
    fn course(
        &self,
        mode: &mode::volume::Volume,
        delay: &DelayGrid,
        time: f64,
        measured: impl FnOnce() -> Arc<Measured>,
    ) -> Arc<Course> {
        let always = self.still.is_some() && mode.is_still();
        self.courses.at(if always { 0.0 } else { time }, || {
            let measured = measured();
            let eased = self.settings.eased(time);
            let range = if always { Interval::new(0.0, 1.0) } else { Interval::new(delay.last(eased), eased) };
            let nodes = Course::nodes(range);
            let t = |progress: f64| self.plan.pace.at(progress).clamp(LEAST_TIME, 1.0 - LEAST_TIME);
            let timed = |progress: f64| {
                let time_there = t(progress);
                Timed { time: time_there, reach: Kernel::<f64>::new(&mode.section(time_there, time)).reach() }
            };
            let a0: Vec<f64> =
                nodes.par_iter().map(|progress| self.enclosing(&measured, time, t(*progress)).a0).collect();
            Course::new(&nodes, &a0, timed).expect("an a₀ found between two finite ones")
        })
    }

    /// Takes the delay, which stands in the world, onto the coarse grid, or onto one over all that it moves through.
    fn measure_delay(&mut self) -> Result<(), Error> {
        let Some(delay) = self.settings.mode.volume().and_then(|mode| mode.delay.as_ref()) else { return Ok(()) };
        let grid = if self.common.is_world() {
            self.plan.grid.clone()
        } else {
            let moves_through =
                box_over(self.plan.grid.aabb(), &self.settings, false, |time| self.common.motion.at(time));
            CoarseGrid::over(moves_through, None)
        };
        self.delay = Some(Arc::new(DelayGrid::new(&grid, delay)?));
        Ok(())
    }

    /// Where an object stands in the frame that moves with both.
    fn seen(&self, object: &MorphObject, time: f64) -> Similarity {
        object.motion.at(time).seen_from(&self.common.motion.at(time))
    }

    pub(super) fn measure(&self, time: f64) -> Measured {
        let first = Moved::new(self.from.distance.clone(), self.seen(&self.from, time));
        let second = Moved::new(self.to.distance.clone(), self.seen(&self.to, time));
        Measured::new(&self.plan.grid, &first, &second, self.plan.unit)
    }

    pub(super) fn measure_still(&mut self) {
        if self.common.rests {
            self.still = Some(Arc::new(self.measure(self.settings.over[0])));
        }
    }

    /// The coarse grid's distances at scene time τ.
    pub(super) fn measured_at(&self, time: f64) -> Arc<Measured> {
        self.still.clone().unwrap_or_else(|| Arc::new(self.measure(time)))
    }

    /// The way round between the objects' mean colours, from the first's distances at the start and the second's at the
    /// end.
    pub(super) fn turn(&self, first: &[f32], second: &[f32]) -> Turn {
        let [start, end] = self.settings.over;
        let (from, to) = (self.mean_colour(&self.from, start, first), self.mean_colour(&self.to, end, second));
        Turn::between(self.settings.colour_space, from, to)
    }

    /// The mean of an object's colour over cells spread evenly over its surface, or else over the whole grid.
    fn mean_colour(&self, object: &MorphObject, time: f64, distances: &[f32]) -> LinearRgb {
        let near = (self.plan.grid.edge() / self.plan.unit) as f32;
        let on_surface: Vec<usize> = (0..distances.len()).filter(|&i| distances[i].abs() < near).collect();
        let cells = if on_surface.is_empty() { (0..distances.len()).collect() } else { on_surface };
        let stride = cells.len().div_ceil(BATCH);
        let colour = Moved::new(object.colour.clone(), self.seen(object, time));
        let mut points = Points::new(self.plan.grid.centre(cells[0]));
        for &cell in cells.iter().step_by(stride) {
            points.push((self.plan.grid.centre(cell) - points.origin).as_vec3());
        }
        let mut colours = [[0.0; 3]; BATCH];
        colour.sampler().sample(&points, &mut colours);
        let mean = |i: usize| colours[..points.len].iter().map(|colour| colour[i]).sum::<f32>() / points.len as f32;
        [mean(0), mean(1), mean(2)]
    }

    /// Paces the morph and finds its extent. Gives the scene time and t at which it first reaches a face of the coarse
    /// grid, if it does.
    fn make_plan(&mut self) -> Result<Option<[f64; 2]>, Error> {
        self.measure_still();
        self.measure_delay()?;
        let progress: Vec<f64> = (0..=STEPS).map(|step| step as f64 / STEPS as f64).collect();
        let scene: Vec<f64> =
            self.settings.shares_of(&progress).into_iter().map(|share| self.settings.time_of(share)).collect();
        let samples: Vec<Measured> = match &self.still {
            Some(_) => Vec::new(),
            None => scene.iter().map(|time| self.measure(*time)).collect(),
        };
        let at = |step: usize| self.still.as_deref().unwrap_or_else(|| &samples[step]);
        let ends = [self.enclosing(at(0), scene[0], 0.0), self.enclosing(at(STEPS), scene[STEPS], 1.0)];
        if ends.iter().all(|end| total(&end.fractions) <= 0.0) {
            return Err(Error::Empty);
        }
        let all = |times: &[f64]| -> Vec<Vec<f32>> {
            let step = |step: usize| self.enclosing(at(step), scene[step], times[step]).fractions;
            (0..=STEPS).into_par_iter().map(step).collect()
        };
        let changes = |times: &[f64]| -> (Vec<f64>, Vec<Vec<f32>>) {
            let fractions = all(times);
            (fractions.par_windows(2).map(|two| difference(&two[0], &two[1])).collect(), fractions)
        };
        let Even { times, changes: in_cells, measured: mut fractions } = if self.paced() {
            even(&progress, changes)
        } else {
            let (changes, measured) = changes(&progress);
            Even { times: progress.clone(), changes, measured }
        };
        self.plan.turn = self.turn(&at(0).first, &at(STEPS).second);
        if self.paced() {
            let points = progress.iter().zip(&times).map(|(progress, t)| [*progress, *t]).collect();
            self.plan.pace = Curve::through(points).unwrap_or_else(Curve::line);
        }
        if self.delay.is_some() || matches!(self.settings.ease, Ease::Keyed(_)) {
            // A progress may be reached several times, while all else goes on, or here earlier than there.
            fractions.extend(
                (0..=STEPS)
                    .into_par_iter()
                    .map(|step| {
                        let time = self.settings.time_of(progress[step]);
                        self.solved(time).enclosing.fractions.clone()
                    })
                    .collect::<Vec<_>>(),
            );
        }
        let cell = self.plan.grid.cell_volume();
        let extent = if self.common.is_world() {
            extent(&self.plan.grid, &fractions)
        } else {
            self.moving_extent(&progress, &scene, &fractions)
        };
        let spreads = fractions.par_iter().position_first(|one| touches_a_face(&self.plan.grid, one));
        let spreads = spreads.map(|step| {
            let time = scene.get(step).copied().unwrap_or_else(|| self.settings.time_of(progress[step - STEPS - 1]));
            [time, self.time_at(time)]
        });
        self.plan.changes = in_cells.into_iter().map(|change| change * cell).collect();
        self.plan.extent = [extent.min.to_array(), extent.max.to_array()];
        Ok(spreads)
    }

    /// The box in the world around all that is inside at any step, where the coarse grid moves: what is inside at two
    /// neighbouring steps is carried along between them.
    fn moving_extent(&self, progress: &[f64], scene: &[f64], fractions: &[Vec<f32>]) -> Aabb {
        const BETWEEN: usize = 8;
        let again = progress.iter().map(|share| self.settings.time_of(*share));
        let times: Vec<f64> = scene.iter().copied().chain(again).take(fractions.len()).collect();
        let own: Vec<Aabb> =
            fractions.par_iter().map(|one| extent(&self.plan.grid, std::slice::from_ref(one))).collect();
        let mut all = Aabb::new(DVec3::INFINITY, DVec3::NEG_INFINITY);
        for step in 0..times.len() {
            // The second list of times, where there is one, starts anew.
            let next = if step + 1 < times.len() && step != STEPS { step + 1 } else { step };
            let here = own[step].union(own[next]);
            if here.min.cmpgt(here.max).any() {
                continue;
            }
            for part in 0..=BETWEEN {
                let share = part as f64 / BETWEEN as f64;
                let common = self.common.motion.at(times[step] + (times[next] - times[step]) * share);
                all = all.union(common.box_to_world(here));
            }
        }
        all
    }
}

/// Objects with the motions that they have as they are carried, the way, and the frame that moves with both.
type Moving = ([MorphObject; 2], Option<Arc<Way>>, Common);

fn carried([from, to]: [MorphObject; 2], settings: &Settings) -> Result<Moving, Error> {
    let way = Way::new(&from, &to, settings)?.map(Arc::new);
    let objects = match &way {
        Some(way) => [on_way(way, Side::From, from), on_way(way, Side::To, to)],
        None => [from, to],
    };
    let common = Common::new(&objects[0], &objects[1], settings, way.as_ref());
    Ok((objects, way, common))
}

/// An object, or a part of it, as it is carried.
pub(super) fn on_way(way: &Arc<Way>, side: Side, object: MorphObject) -> MorphObject {
    MorphObject { motion: way.carried(side, &object.motion), ..object }
}

/// The box around a box wherever it is placed while the shape changes.
fn box_over(own: Aabb, settings: &Settings, still: bool, placement: impl Fn(f64) -> Similarity) -> Aabb {
    let steps = if still { 0 } else { BOX_STEPS };
    let at = |step: usize| placement(settings.time_of(step as f64 / BOX_STEPS as f64)).box_to_world(own);
    (1..=steps).map(at).fold(at(0), Aabb::union)
}

fn touches_a_face(grid: &CoarseGrid, fractions: &[f32]) -> bool {
    fractions.iter().enumerate().any(|(cell, fraction)| *fraction > 0.0 && grid.on_face(cell))
}

/// The box around all that is inside at any step; a cell counts as far from its middle as its fraction says.
fn extent(grid: &CoarseGrid, steps: &[Vec<f32>]) -> Aabb {
    let nothing = Aabb::new(DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut most = vec![0.0f32; grid.cell_count()];
    for fractions in steps {
        most.iter_mut().zip(fractions).for_each(|(most, fraction)| *most = most.max(*fraction));
    }
    most.iter().enumerate().filter(|(_, fraction)| **fraction > 0.0).fold(nothing, |all, (cell, fraction)| {
        let (centre, inside) = (grid.centre(cell), f64::from(*fraction) - 0.5);
        let mut reach = DVec3::splat(inside * grid.edge());
        if let Some(depth) = grid.depth() {
            reach.z = 0.5 * depth;
        }
        all.union(Aabb::new(centre - reach, centre + reach))
    })
}
