//! Space-time blending with the papers' numbers.

use std::sync::Arc;

use crate::morph::{Numbers, OverTime, Paper, Round};
use crate::node::morph_mode::{ModeSpec, Setting};
use crate::text::frames::{plain, sampled_frames};
use crate::text::key::Absent::{Nothing, Number, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Space-time blending by hand.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named(
        "paper",
        "Space-time blending with a₀ … a₃ and s as given, t as it comes; frames may be empty.",
    ),
    parameters: &[
        Key::new("a0", Kind::Number, Number(1.0), "How much is added between them; 0 is their plain union."),
        Key::new("a1", Kind::Number, Number(1.0), "How far the first reaches.").limit(Limit::Positive),
        Key::new("a2", Kind::Number, Number(1.0), "How far the second reaches.").limit(Limit::Positive),
        Key::new("a3", Kind::Number, Number(1.0), "How far the slab of time reaches.").limit(Limit::Positive),
        Key::new("s", Kind::Number, Number(1.0), "The scale of time against space.")
            .limit(Limit::Positive)
            .also(&["time_scale"]),
        Key::new("slab", Kind::Span, Words("`[0, 1]`"), "The slab of time that bounds the blend."),
        Key::new(
            "round",
            Kind::Round,
            Nothing,
            "Rounds both objects against the planes that cut them in time (eq. 6): see [`round`](scene.md#round-of-morph).",
        ),
    ],
    shared: &["carry", "anchors", "arc", "carry_ease", "ease", "over", "through", "at"],
    formula: "the section at t of g₁ ∨₀ g₂ + a₀·disp, g₁ and g₂ the objects as half-cylinders over time",
    source: "heterogeneous STB, eqs. 5 and 6",
    example: "from = \"a\"\nto = \"b\"\nmode = \"paper\"\na0 = 0.3\na1 = 2.5\na2 = 2.5\na3 = 0.05\ns = 0.25",
    carries_apart: false,
    where_empty: Some("a wider `slab` such as [-1, 2], a smaller s and a3, greater a1 and a2, or `mode = \"volume\"`"),
    by_level_sets: false,
    build: |setting| Ok(Arc::new(Paper(numbers(setting)?))),
};

/// The papers' numbers over scene time.
fn numbers(setting: &dyn Setting) -> Result<OverTime<Numbers>, Problem> {
    let arguments = setting.arguments();
    let a = [setting.number("a0")?, setting.number("a1")?, setting.number("a2")?, setting.number("a3")?];
    let s = setting.number("s")?;
    let ends = match arguments.pair("slab") {
        None => [0.0, 1.0].map(OverTime::still),
        Some([lo, hi]) => [setting.over_time(lo)?, setting.over_time(hi)?],
    };
    let round = match arguments.round("round") {
        None => None,
        Some([a0, reach, a3, depth]) => Some(
            [a0, reach, a3, depth]
                .map(|number| setting.over_time(number))
                .into_iter()
                .collect::<Result<Vec<_>, _>>()?,
        ),
    };
    for frame in sampled_frames(setting.frames()) {
        let [lo, hi] = ends.each_ref().map(|end| end.at(setting.frames().share(frame)));
        if lo >= hi {
            let problem =
                format!("`morph.slab` is [{lo}, {hi}] at frame {}, and must end after it starts", plain(frame));
            return Err(Problem::new(arguments.span("slab").unwrap_or(setting.span()), problem));
        }
    }
    let still = a.iter().chain([&s]).chain(&ends).chain(round.iter().flatten()).all(OverTime::is_still);
    let at = move |time: f64| Numbers {
        slab: ends.each_ref().map(|end| end.at(time)),
        time_scale: s.at(time),
        a: a.each_ref().map(|a| a.at(time)),
        round: round.as_ref().map(|of| Round {
            a0: of[0].at(time),
            reach: of[1].at(time),
            a3: of[2].at(time),
            depth: of[3].at(time),
        }),
    };
    Ok(if still { OverTime::still(at(0.0)) } else { OverTime::moving(at) })
}
