//! A morph's settings as the morph takes them: by scene time, tried at every frame.

use std::sync::Arc;

use crate::attribute::ColourSpace;
use crate::morph::{self, Carry, Ease, OverTime};

use crate::node::model::{Model, Morph, MorphEase};
use crate::node::over_time::{Morphing, ROUNDING, ends_at, over_time, span_of};
use crate::text::number::Number;
use crate::text::problem::Problem;

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
    })
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
