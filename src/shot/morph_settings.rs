//! A morph's settings as the morph takes them: by scene time, tried at every frame.

use std::sync::Arc;

use crate::attribute::ColourSpace;
use crate::morph::{self, Carry, Ease, OverTime};

use crate::node::argument::Arguments;
use crate::node::model::{Model, Morph, MorphEase};
use crate::node::morph_mode::Setting;
use crate::text::frames::FrameRange;
use crate::text::number::Number;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// How far formulas may miss the ends of a curve by rounding.
const ROUNDING: f64 = 1e-9;
/// The most frames at which a number that changes is tried; of more, so many evenly.
const MOST_TRIED: usize = 10_000;

/// The settings of a scene's morph but for its carry, or what is wrong at which frame.
pub(crate) fn settings(
    model: &Arc<Model>,
    morph: &Morph,
    delay: Option<morph::Delay>,
) -> Result<morph::Settings, Problem> {
    let mode = (morph.mode.spec.build)(&Morphing { model, morph, delay })?;
    Ok(morph::Settings {
        mode,
        carry: Carry::None,
        over: span_of(model, morph.over),
        ease: ease(model, morph, &morph.ease)?,
        carry_ease: morph.carry_ease.as_ref().map(|of_way| ease(model, morph, of_way)).transpose()?,
        arc: morph.arc.into(),
        colour_over: span_of(model, morph.colour_over),
        octopus: morph.octopus,
        alpha: over_time(model, &morph.alpha)?,
        beta: over_time(model, &morph.beta)?,
        colour_space: ColourSpace::named(morph.colour_space).unwrap_or(ColourSpace::Auto),
        plane: None,
    })
}

/// What the mode of a scene's morph is built from.
struct Morphing<'a> {
    model: &'a Arc<Model>,
    morph: &'a Morph,
    /// The places that wait.
    delay: Option<morph::Delay>,
}

impl Setting for Morphing<'_> {
    fn arguments(&self) -> &Arguments {
        &self.morph.mode.arguments
    }

    fn pace(&self) -> morph::Pace {
        if self.morph.even_pace { morph::Pace::Even } else { morph::Pace::Time }
    }

    fn delay(&self) -> Option<morph::Delay> {
        self.delay.clone()
    }

    fn frames(&self) -> FrameRange {
        self.model.shot.range
    }

    fn span(&self) -> Span {
        self.morph.span
    }

    fn over_time(&self, number: &Number) -> Result<OverTime<f64>, Problem> {
        over_time(self.model, number)
    }

    fn factor(&self, key: &str) -> Result<OverTime<f64>, Problem> {
        let number = self.arguments().number(key).expect("it has a default");
        ends_at(self.model, self.morph, number, [1.0, 1.0], "such as { 1 = 1, 24 = 1.5, 48 = 1 }")?;
        let inner = self.over_time(number)?;
        if inner.is_still() {
            return Ok(inner);
        }
        let [start, end] = span_of(self.model, self.morph.over);
        Ok(OverTime::moving(move |time| {
            let at = inner.at(time);
            if time <= start || time >= end || (at - 1.0).abs() < ROUNDING { 1.0 } else { at }
        }))
    }
}

/// Scene times of some frames. Not held: a span may begin before the shot, or end after it.
fn span_of(model: &Model, range: FrameRange) -> [f64; 2] {
    let FrameRange { first, last } = model.shot.range;
    [range.first, range.last].map(|frame| (frame - first) as f64 / (last - first).max(1) as f64)
}

/// A number over scene time. It is tried at every frame of the shot now, so that errors come with their place; what
/// lies between frames is held to them.
fn over_time(model: &Arc<Model>, number: &Number) -> Result<OverTime<f64>, Problem> {
    let range = model.shot.range;
    if !model.varies(number) {
        return Ok(number.at(&model.moment(range.first as f64))?.into());
    }
    let (last, count) = (range.count() - 1, range.count().min(MOST_TRIED));
    let frame = |i: usize| (range.first + (last as f64 * (i as f64 / (count - 1).max(1) as f64)).round() as i64) as f64;
    let tried: Vec<f64> = (0..count).map(|i| number.at(&model.moment(frame(i)))).collect::<Result<_, _>>()?;
    let (model, number) = (Arc::clone(model), number.clone());
    Ok(OverTime::moving(move |time| {
        let time = time.clamp(0.0, 1.0);
        let nearest = (time * (tried.len() - 1) as f64).round() as usize;
        number.at(&model.moment(model.shot.frame_at(time))).unwrap_or(tried[nearest])
    }))
}

/// Refuses a number that is not as it must be at the first and at the last frame of `over`, where the shot shows them.
fn ends_at(model: &Model, morph: &Morph, number: &Number, ends: [f64; 2], help: &str) -> Result<(), Problem> {
    let FrameRange { first, last } = model.shot.range;
    for (frame, end) in [morph.over.first, morph.over.last].into_iter().zip(ends) {
        if !(first..=last).contains(&frame) {
            continue;
        }
        let at = number.at(&model.moment(frame as f64))?;
        if (at - end).abs() > ROUNDING {
            let problem = format!("`{}` is {at} at frame {frame}, and must be {end} there", number.name);
            return Err(
                Problem::new(number.span, problem).help(format!("a morph begins and ends as its objects: keys {help}"))
            );
        }
    }
    Ok(())
}

fn ease(model: &Arc<Model>, morph: &Morph, ease: &MorphEase) -> Result<Ease, Problem> {
    Ok(match ease {
        MorphEase::Linear => Ease::Linear,
        MorphEase::Smooth => Ease::Smooth,
        MorphEase::Progress(progress) => Ease::Keyed(progress_over_time(model, morph, progress)?),
    })
}

/// The progress by keys or formula, exactly 0 and 1 at its ends.
fn progress_over_time(model: &Arc<Model>, morph: &Morph, progress: &Number) -> Result<OverTime<f64>, Problem> {
    ends_at(model, morph, progress, [0.0, 1.0], "such as { 1 = 0, 24 = 0.8, 48 = 1, ease = \"bezier\" }")?;
    let inner = over_time(model, progress)?;
    Ok(OverTime::moving(move |time| {
        let at = inner.at(time);
        if at < ROUNDING {
            0.0
        } else if at > 1.0 - ROUNDING {
            1.0
        } else {
            at
        }
    }))
}
