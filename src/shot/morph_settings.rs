//! A morph's settings as the morph takes them: by scene time, tried at every frame.

use std::sync::Arc;

use crate::attribute::ColourSpace;
use crate::morph::{self, Carry, Ease, Flow, Mode, OverTime, Pace, Paper, Round};

use crate::node::model::{Model, Morph, MorphEase, MorphMode, MorphPaper};
use crate::text::frames::FrameRange;
use crate::text::frames::sampled_frames;
use crate::text::number::Number;
use crate::text::problem::Problem;

/// How far formulas may miss the ends of a curve by rounding.
const ROUNDING: f64 = 1e-9;
/// The most frames at which a number that changes is tried; of more, so many evenly.
const MOST_TRIED: usize = 10_000;

/// The settings of a scene's morph but for its delay and its carry, or what is wrong at which frame.
pub(crate) fn settings(model: &Arc<Model>, morph: &Morph) -> Result<morph::Settings, Problem> {
    let pace = if morph.even_pace { Pace::Even } else { Pace::Time };
    let mode = match &morph.mode {
        MorphMode::Volume { bridge, volume, delay: _ } => Mode::Flow(Flow {
            bridge: over_time(model, bridge)?,
            pace,
            volume: volume_over_time(model, morph, volume)?,
            delay: None,
        }),
        MorphMode::Linear => Mode::Linear(pace),
        // Where OpenVDB makes the shape, attributes go as ever, and what is in either object bounds it.
        MorphMode::Union | MorphMode::OpenVdb => Mode::Union,
        MorphMode::Still => Mode::Still,
        MorphMode::Paper(numbers) => Mode::Paper(paper(model, numbers)?),
    };
    Ok(morph::Settings {
        mode,
        carry: Carry::None,
        over: span(model, morph.over),
        ease: match &morph.ease {
            MorphEase::Linear => Ease::Linear,
            MorphEase::Smooth => Ease::Smooth,
            MorphEase::Progress(progress) => Ease::Keyed(progress_over_time(model, morph, progress)?),
        },
        colour_over: span(model, morph.colour_over),
        octopus: morph.octopus,
        alpha: over_time(model, &morph.alpha)?,
        beta: over_time(model, &morph.beta)?,
        colour_space: ColourSpace::named(morph.colour_space).unwrap_or(ColourSpace::Auto),
    })
}

/// Scene times of some frames. Not held: a span may begin before the shot, or end after it.
fn span(model: &Model, range: FrameRange) -> [f64; 2] {
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

/// The papers' numbers over scene time.
fn paper(model: &Arc<Model>, numbers: &MorphPaper) -> Result<OverTime<Paper>, Problem> {
    let MorphPaper { a, s, slab, round } = numbers;
    let timed = |number: &Number| over_time(model, number);
    let a = [timed(&a[0])?, timed(&a[1])?, timed(&a[2])?, timed(&a[3])?];
    let (s, ends) = (timed(s)?, [timed(&slab[0])?, timed(&slab[1])?]);
    let round = match round {
        None => None,
        Some(round) => Some([timed(&round.a0)?, timed(&round.reach)?, timed(&round.a3)?, timed(&round.depth)?]),
    };
    for frame in sampled_frames(model.shot.range) {
        let [lo, hi] = ends.each_ref().map(|end| end.at(model.shot.range.share(frame)));
        if lo >= hi {
            let frame = crate::text::frames::plain(frame);
            let problem = format!("`morph.slab` is [{lo}, {hi}] at frame {frame}, and must end after it starts");
            return Err(Problem::new(slab[0].span, problem));
        }
    }
    let still = a.iter().chain([&s]).chain(&ends).chain(round.iter().flatten()).all(OverTime::is_still);
    let at = move |time: f64| Paper {
        slab: ends.each_ref().map(|end| end.at(time)),
        time_scale: s.at(time),
        a: a.each_ref().map(|a| a.at(time)),
        round: round.as_ref().map(|[a0, reach, a3, depth]| Round {
            a0: a0.at(time),
            reach: reach.at(time),
            a3: a3.at(time),
            depth: depth.at(time),
        }),
    };
    Ok(if still { OverTime::still(at(0.0)) } else { OverTime::moving(at) })
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

/// The factor on the volume, exactly 1 at its ends.
fn volume_over_time(model: &Arc<Model>, morph: &Morph, volume: &Number) -> Result<OverTime<f64>, Problem> {
    ends_at(model, morph, volume, [1.0, 1.0], "such as { 1 = 1, 24 = 1.5, 48 = 1 }")?;
    let inner = over_time(model, volume)?;
    if inner.is_still() {
        return Ok(inner);
    }
    let [start, end] = span(model, morph.over);
    Ok(OverTime::moving(move |time| {
        let at = inner.at(time);
        if time <= start || time >= end || (at - 1.0).abs() < ROUNDING { 1.0 } else { at }
    }))
}
